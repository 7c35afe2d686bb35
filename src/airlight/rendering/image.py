"""Images: float radiance with opacity and depth, and their way into files."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..annotations.drawing import over, overlay
from ..errors import DataError, FileError, MissingExtraError, ValueRangeError
from ..transfer.colour import linear_to_srgb
from .disagreement import disagreement_of
from .dithering import bytes_of

if TYPE_CHECKING:
    from ..annotations.marks import Mark
    from ..picking import Picked
    from ..profiles import RayProfile
    from ..scene import Scene
    from .hits import Hits

FloatImage = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Image:
    """A finished frame.

    Attributes
    ----------
    rgba
        float32 (height, width, 4), first row on top, linear light after the tone stage, premultiplied; alpha is the opacity
        of the scene, the background is not in it.
    depth
        float32 (height, width), world distance from the eye (orthographic: from its plane); inf where there is none.
    background
        Linear colour that lies behind; None is transparent.
    stats
        What was done: adapter, samples, milliseconds by pass, texture formats and their error, what was skipped.
    hits
        What was met, where it was asked for (``keep_hits``): normals, and what ``relight`` needs of surfaces.
    scene
        What was drawn, with its transfer functions and camera: what ``pick`` asks. It holds the volumes;
        ``dataclasses.replace(image, scene=None)`` lets them go.
    marks
        What the scene's annotations write on the picture, in pixels: ``rgb`` and ``picture`` show it, ``rgba`` does not.
    estimate
        float32 (height, width), where a ``tolerance`` was asked for: bound of the error of each pixel, of whichever channel.
    """

    rgba: FloatImage
    depth: FloatImage
    background: tuple[float, float, float] | None = None
    stats: dict[str, Any] = field(default_factory=dict)
    hits: Hits | None = None
    scene: Scene | None = None
    marks: tuple[Mark, ...] = ()
    estimate: FloatImage | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.rgba.shape[1], self.rgba.shape[0]

    @property
    def normal(self) -> FloatImage:
        """float32 (height, width, 3): unit normals in the world, towards lower values; 0 where there is none.

        They are those of surfaces (``first_hit``), or of the field where opacity passes one half (``emission_absorption``).

        Raises
        ------
        DataError
            When surfaces were not kept.
        """
        if self.hits is None:
            raise DataError("image.normal", "was not kept", "render with keep_hits=True")
        return self.hits.normal

    @property
    def disagreement(self) -> FloatImage:
        """float32 (height, width): how far neighbouring offsets disagree, a sign that the step is too large.

        Standard deviation of the linear colour or opacity that they cause: see ``rendering/disagreement.py``.

        Raises
        ------
        DataError
            When the samples of all pixels lie at the same distances, or those of a pixel at none of sixteen, when their steps
            differ (``tolerance``), and when the picture was enlarged (``budget_ms``).
        """
        if "disagreement" not in self.stats:
            what = "is that of interleaved offsets at one step, and these were not drawn pixel by pixel"
            raise DataError("image.disagreement", what, 'render with driver=al.driver.March(offsets="interleaved")')
        return disagreement_of(self.rgba)

    def pick(self, x_px: int, y_px: int, *, layer: int | None = None) -> Picked | None:
        """Return what a pixel shows: the point, its value, gradient and label; None where there is no depth.

        It is the surface of ``first_hit``, the extreme of ``mip`` and ``minip``, and else where opacity passes one half.
        Values and gradients are computed without the device, in float64, as the layer's stages define them.

        Parameters
        ----------
        x_px, y_px
            Column and row, from 0, counted from the upper left corner.
        layer
            Number of the visible layer that is asked; None is the one that shows most there.

        Raises
        ------
        ValueRangeError
            For pixels outside of the image or between its pixels, and layers that are not there.
        DataError
            When the image does not know its scene, or that shows no volume.
        StageError
            When only the device knows the camera's rays.
        """
        from ..picking import picked

        return picked(self, self._known_scene, (x_px, y_px), layer)

    def profile(self, x_px: int, y_px: int, *, layer: int = 0, step: float = 0.5) -> RayProfile:
        """Return what the ray of a pixel's centre meets: values, extinction, colour and opacity along it.

        See ``airlight.ray_profile`` for parameters and errors.
        """
        from ..profiles import ray_profile

        return ray_profile(self._known_scene, self.size, (x_px + 0.5, y_px + 0.5), layer=layer, step=step)

    @property
    def _known_scene(self) -> Scene:
        if self.scene is None:
            raise DataError("image", "does not know its scene", "use airlight.pick(image, scene, pixel)")
        return self.scene

    @property
    def rgb(self) -> FloatImage:
        """float32 (height, width, 3), linear light over the background, or over black where it is transparent.

        Annotations lie over it.
        """
        behind = np.asarray(self.background or (0.0, 0.0, 0.0), dtype=np.float32)
        rgb = np.asarray(self.rgba[..., :3] + (1 - self.rgba[..., 3:]) * behind)
        return rgb if self._overlay is None else over(self._overlay, rgb)

    @cached_property
    def _overlay(self) -> FloatImage | None:
        return overlay(self.marks, self.size) if self.marks else None

    def picture(self, *, dither: bool = False) -> npt.NDArray[np.uint8]:
        """uint8 sRGB as it is saved and shown: (h, w, 3), or (h, w, 4) with straight alpha where it is transparent.

        With ``dither`` what lies between two of the 256 steps becomes fine noise of both, instead of bands.
        """
        if self.background is not None:
            return bytes_of(linear_to_srgb(self.rgb), dither)
        rgba = self.rgba if self._overlay is None else over(self._overlay, self.rgba)
        alpha = rgba[..., 3:]
        straight = np.divide(rgba[..., :3], alpha, out=np.zeros_like(rgba[..., :3]), where=alpha > 0)
        return bytes_of(np.concatenate([linear_to_srgb(straight), np.clip(alpha, 0, 1)], axis=-1), dither)

    def png(self, *, dither: bool = False) -> bytes:
        """Return the picture as a PNG file."""
        from PIL import Image as Pillow

        out = io.BytesIO()
        Pillow.fromarray(self.picture(dither=dither)).save(out, "png", compress_level=4)
        return out.getvalue()

    def save(self, path: str | os.PathLike[str], *, dither: bool = False, half: bool = False) -> Path:
        """Write ``.png`` (sRGB, over the background, annotated), ``.exr`` (linear RGBA and depth Z) or ``.npy`` (``rgba``).

        The file appears when it is complete. ``dither`` is for the 8 bits of ``.png``, see ``picture``; with ``half`` colours
        and opacity of ``.exr`` have 16 bits, to three digits.

        Raises
        ------
        ValueRangeError
            For an option that means nothing to the kind of file.
        FileError
            For other endings, and where the file cannot be written.
        MissingExtraError
            For EXR without the package OpenEXR.
        """
        target = Path(path)
        writers: dict[str, Callable[[Path], None]] = {
            ".png": lambda path: self._write_png(path, dither),
            ".exr": lambda path: self._write_exr(path, half),
            ".npy": self._write_npy,
        }
        writer = writers.get(target.suffix.lower())
        if writer is None:
            raise FileError(str(target), "has no ending that says what to write", "use one of " + ", ".join(writers))
        check_file_options(target, dither, half)
        try:
            handle, name = tempfile.mkstemp(prefix=".airlight-", suffix=target.suffix.lower(), dir=target.parent)
        except OSError as error:
            raise FileError(str(target), f"cannot be written ({error.strerror})", "choose a folder that is there") from error
        os.close(handle)
        try:
            writer(Path(name))
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(name, 0o666 & ~mask)
            os.replace(name, target)
        except OSError as error:
            raise FileError(str(target), f"cannot be written ({error.strerror or error})") from error
        finally:
            Path(name).unlink(missing_ok=True)
        return target

    def _write_png(self, path: Path, dither: bool) -> None:
        path.write_bytes(self.png(dither=dither))

    def _write_npy(self, path: Path) -> None:
        np.save(path, self.rgba, allow_pickle=False)

    def _write_exr(self, path: Path, half: bool) -> None:
        OpenEXR = _open_exr()  # noqa: N806 - the name of the module
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        with np.errstate(over="ignore", under="ignore"):  # what is beyond half floats is infinite there, or zero
            rgba = self.rgba.astype(np.float16 if half else np.float32)
        channels = {"RGBA": np.ascontiguousarray(rgba), "Z": np.ascontiguousarray(self.depth)}
        try:
            with OpenEXR.File(header, channels) as file:
                file.write(str(path))
        except RuntimeError as error:  # what OpenEXR raises, for whatever reason, with the name of the unfinished file
            raise OSError(str(error).rpartition('". ')[2]) from error

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """Return ``picture()``, so that plotting libraries show what is saved."""
        return self.picture().astype(dtype or np.uint8, copy=False)

    def _repr_png_(self) -> bytes:
        return self.png()

    def __repr__(self) -> str:
        return f"Image({self.size[0]}x{self.size[1]}, covered {float((self.rgba[..., 3] > 0).mean()):.0%})"


def _open_exr() -> Any:
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingExtraError("writing EXR", "needs OpenEXR", 'pip install "airlight[exr]"') from error
    return OpenEXR


def check_file_options(path: Path, dither: bool, half: bool) -> None:
    """Refuse options that mean nothing to a kind of file, and a kind for which a package is missing.

    Raises
    ------
    ValueRangeError
        Names the option.
    MissingExtraError
        Names the package.
    """
    ending = path.suffix.lower()
    if ending == ".exr":
        _open_exr()
    if dither and ending != ".png":
        raise ValueRangeError("dither", f"is for 8 bits, and {ending} files hold floats", "leave it out, or write .png")
    if half and ending != ".exr":
        raise ValueRangeError("half", "is for .exr files alone", "leave it out, or write .exr")
