"""What is looked at: a scene and how it is drawn, as one frozen value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from ..scene import Camera, Scene
from ..stage import Stage, make_stage
from ..volume import Volume

TOLERANCE = 1 / 255


@dataclass(frozen=True)
class Document:
    """A scene and how it is drawn.

    Parameters
    ----------
    scene
        The scene; its camera is a ``Camera``, never the name of a view.
    driver, step, skip, passes
        As for ``airlight.render``: what is drawn once nothing moves.
    tolerance
        Bound of the error to which the picture is refined at rest; None leaves it at ``step``.
    chosen_for
        Width over height of the view that the camera was chosen for, from the data: narrower views stand back. None for cameras
        that somebody named.
    """

    scene: Scene
    driver: Stage = field(default_factory=lambda: make_stage("driver", "march"))
    step: float = 1.0
    skip: str = "auto"
    tolerance: float | None = TOLERANCE
    passes: tuple[Stage, ...] = ()
    chosen_for: float | None = field(default=None, compare=False)

    @property
    def camera(self) -> Camera:
        """The scene's camera."""
        assert isinstance(self.scene.camera, Camera)
        return self.scene.camera

    @property
    def volumes(self) -> list[Volume]:
        """What its layers draw, and their labels' volumes."""
        layers = self.scene.layers
        return [layer.volume for layer in layers] + [layer.labels.volume for layer in layers if layer.labels is not None]

    def with_camera(self, camera: Camera) -> Document:
        """Return the same seen by another camera."""
        return replace(self, scene=replace(self.scene, camera=camera))

    @property
    def drawing(self) -> dict[str, Any]:
        """Arguments of ``airlight.render`` that draw it."""
        return {"driver": self.driver, "step": self.step, "skip": self.skip, "passes": self.passes}

    @property
    def refining(self) -> dict[str, Any]:
        """Arguments of ``Renderer.refine`` that go on from its picture."""
        known = {name: value for name, value in self.drawing.items() if name != "step"}
        return known | {"tolerance": self.tolerance, "coarse": False}
