"""The functions that users call first: ``render``, ``explain``, ``devices``, ``warm_up``."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from .errors import ValueRangeError
from .first_picture import first_picture
from .scene import Look, Scene
from .stage import Stage
from .transfer.given import check_size
from .volume import Volume

if TYPE_CHECKING:
    from .gpu.device import DeviceInfo
    from .gpu.textures import Progress
    from .rendering.image import Image

LOOK_SLOTS = ("field", "gradient", "transfer", "modulation", "shade", "lighting", "visibility", "integrate", "tone")


def render(
    what: Any,
    size: tuple[int, int] = (512, 512),
    *,
    driver: str | Stage = "march",
    step: float = 1.0,
    skip: str = "auto",
    tolerance: float | None = None,
    budget_ms: float | None = None,
    keep_hits: bool = False,
    passes: Iterable[str | Stage] = (),
    device: str | int | None = None,
    progress: Progress | None = None,
) -> Image:
    """Draw a scene, a volume or a file.

    Parameters
    ----------
    what
        A ``Scene``, or the path of a scene file (``.toml``, of which the scene is taken). A ``Volume``, an array, an image of
        nibabel, SimpleITK or xarray, or the path of a volume get a good first picture: transfer function, view and lights
        chosen from the data.
    size
        Width and height in pixels.
    driver
        What walks through the volume, by name or as a stage.
    step
        Distance between samples, in smallest voxel spacings.
    skip
        How empty space is skipped, which never changes the image: ``"blocks"`` of voxels are leapt over; ``"geometry"`` draws
        the faces round those that hold something, too, and rays go from the first to the last; ``"none"``; ``"auto"`` chooses.
    tolerance
        Bound of the error of every pixel and channel of ``rgba``, in [1e-5, 1): the picture is drawn with smaller and smaller
        steps, where it still changes, and without tables and early ends. ``stats["tolerance"]`` tells the estimate and how
        many pixels, if any, it leaves over the bound.
    budget_ms
        Milliseconds that the frame may take: scale and step follow from what frames like it took. What is drawn smaller is
        enlarged, and ``stats["budget"]`` says so.
    keep_hits
        Keep what was found at surfaces (``first_hit``): ``image.normal``, and what ``relight`` needs; of
        ``emission_absorption`` the normals where opacity passes one half.
    passes
        What is made of the picture once it is there, by name or as stages of the slot ``passes``; see
        ``docs/guide/own-passes.md``.
    device
        Number, kind or part of the name of an adapter; None takes the best.
    progress
        Called with what is done, how much of it, and how much there is.

    Returns
    -------
    Image
        ``.rgba``, ``.rgb``, ``.depth``, ``.stats``, ``.save(path)``.

    Raises
    ------
    AirlightError
        For files that cannot be read, data that cannot be drawn, parameters out of range, and devices that fail.

    Examples
    --------
    >>> import airlight as al, numpy as np
    >>> z, y, x = np.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
    >>> image = al.render(np.exp(-4 * (x**2 + y**2 + z**2)), size=(64, 64))
    >>> image.rgba.shape
    (64, 64, 4)
    """
    from .rendering.renderer import shared

    check_size(size)
    scene = as_scene(what, size, progress)
    options: dict[str, Any] = {"tolerance": tolerance, "budget_ms": budget_ms, "keep_hits": keep_hits, "progress": progress}
    options["passes"] = passes
    return shared(device).render(scene, size, driver=driver, step=step, skip=skip, **options)


def relight(
    image: Image,
    scene: Scene,
    *,
    passes: Iterable[str | Stage] = (),
    device: str | int | None = None,
    progress: Progress | None = None,
) -> Image:
    """Light the surfaces of an image again, without another march.

    Lights, shade, lighting, visibility, colours of the transfer function, tone and background may be others than those with
    which the image was drawn; the result is that of drawing the scene anew.

    Parameters
    ----------
    image
        An image that was drawn with ``keep_hits=True``.
    scene
        The scene with its changes.
    passes, device, progress
        As for ``render``.

    Raises
    ------
    DataError
        When the image has kept no surfaces, or the scene's lie elsewhere.

    Examples
    --------
    >>> import airlight as al
    >>> volume = al.samples.load("vortex", size=32)
    >>> look = al.Look(integrate=al.integrate.FirstHit(iso=2.0))
    >>> tf = al.TransferFunction([(0, "white", 0), (3, "white", 1)])
    >>> image = al.render(al.Scene(volume, transfer=tf, camera="iso", look=look), (64, 64), keep_hits=True)
    >>> lamp = al.Light.directional(to_light=(1, 0, 0))
    >>> again = al.relight(image, al.Scene(volume, transfer=tf, camera="iso", look=look, lights=[lamp]))
    """
    from .rendering.renderer import shared

    return shared(device).relight(image, scene, passes=passes, progress=progress)


def as_scene(what: Any, size: tuple[int, int] = (512, 512), progress: Progress | None = None) -> Scene:
    """Scene of a scene, or the good first picture of a volume, an array or a file."""
    if isinstance(what, Scene):
        return what
    if isinstance(what, (str, os.PathLike)):
        if os.fspath(what).endswith(".toml"):
            from .scene_file import load_scene

            return load_scene(os.fspath(what))[0]
        from . import io

        what = io.open(what, progress=progress)
    volume = what if isinstance(what, Volume) else Volume(what)
    return first_picture(volume, size)


def explain(
    what: Any,
    size: tuple[int, int] = (512, 512),
    *,
    driver: str | Stage = "march",
    device: str | int | None = None,
) -> str:
    """Return the linked program of a scene: where each part comes from, offsets of parameters, and the key of the cache."""
    from .rendering.renderer import shared

    program = shared(device).explain(as_scene(what, size), size, driver)
    return f"// key: {program.key}\n{program.linked.text}"


def devices(wanted: str | None = None) -> list[DeviceInfo]:
    """Adapters of this machine; the one that would be used is marked as chosen."""
    from .gpu.device import devices as listed

    return listed(wanted)


def warm_up(device: str | int | None = None) -> None:
    """Open the device in the background, so that the first frame finds it ready; returns at once."""
    from .rendering.renderer import shared

    shared(device).warm_up()


def edit(look: Look, path: str, value: Any) -> Look:
    """Return a look with one parameter changed, e.g. ``edit(look, "integrate.opaque_at", 0.9)``."""
    from dataclasses import replace

    slot, _, name = path.partition(".")
    if slot not in LOOK_SLOTS:
        raise ValueRangeError("path", f"is {path!r}", "begin it with one of " + ", ".join(LOOK_SLOTS))
    stage = getattr(look, slot)
    if name and name not in set(stage.__dataclass_fields__):
        raise ValueRangeError("path", f"is {path!r}", f"{stage.name} has {', '.join(stage.__dataclass_fields__) or 'nothing'}")
    changed = replace(stage, **{name: value}) if name else value
    return Look(**{s: changed if s == slot else getattr(look, s) for s in LOOK_SLOTS})
