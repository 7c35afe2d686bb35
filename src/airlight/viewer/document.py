"""What is looked at: a scene and how it is drawn, as one frozen value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from ..scene import Camera, Scene
from ..stage import Stage, make_stage

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
    """

    scene: Scene
    driver: Stage = field(default_factory=lambda: make_stage("driver", "march"))
    step: float = 1.0
    skip: str = "auto"
    tolerance: float | None = TOLERANCE
    passes: tuple[Stage, ...] = ()

    @property
    def camera(self) -> Camera:
        """The scene's camera."""
        assert isinstance(self.scene.camera, Camera)
        return self.scene.camera

    def with_camera(self, camera: Camera) -> Document:
        """Return the same seen by another camera."""
        return replace(self, scene=replace(self.scene, camera=camera))

    @property
    def drawing(self) -> dict[str, Any]:
        """Arguments of ``airlight.render`` that draw it."""
        return {"driver": self.driver, "step": self.step, "skip": self.skip, "passes": self.passes}
