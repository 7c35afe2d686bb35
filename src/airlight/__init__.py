"""airlight renders volumes: CT, MRI, microscopy, simulations.

>>> import airlight as al
>>> image = al.render("head.nii.gz", size=(1024, 1024))    # doctest: +SKIP
>>> image.save("head.png")                                 # doctest: +SKIP
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .annotations import Axes, ColorBar, Grid, Orientation, Pointer, ScaleBar
from .api import devices, edit, explain, relight, render, warm_up
from .clips import Clip
from .environment import Environment
from .errors import (
    AirlightError,
    DataError,
    DeviceError,
    FileError,
    LimitError,
    MissingExtraError,
    ShaderError,
    StageError,
    ValueRangeError,
)
from .first_picture import automatic_channels, first_picture
from .geometry import Lines, Mesh, Points
from .labels import Labels, LabelStyle
from .scene import Camera, Layer, Light, Look, Scene, fit_camera
from .stage import F32, I32, U32, Bool, Stage, Vec2f, Vec3f, Vec4f, param, register, static
from .stages import (
    camera,
    driver,
    field,
    gradient,
    integrate,
    lighting,
    modulation,
    passes,
    shade,
    tone,
    transfer,
    transport,
    visibility,
)
from .stages.passes import Pass
from .transfer import Channel, Channels, JointFunction, Surface, TransferFunction
from .volume import Volume, statistics

if TYPE_CHECKING:
    from . import automatic, joint, movies, reference, samples
    from .io import open, save
    from .movies import movie
    from .pages import export
    from .picking import Picked, pick
    from .profiles import RayProfile, ray_profile
    from .rendering.image import Image
    from .rendering.renderer import Renderer
    from .scene_file import load_scene, save_scene
    from .transfer import presets
    from .viewer.showing import view

__version__ = "0.1.0.dev0"

__all__ = [
    "F32",
    "I32",
    "U32",
    "AirlightError",
    "Axes",
    "Bool",
    "Camera",
    "Channel",
    "Channels",
    "Clip",
    "ColorBar",
    "DataError",
    "DeviceError",
    "Environment",
    "FileError",
    "Grid",
    "Image",
    "JointFunction",
    "LabelStyle",
    "Labels",
    "Layer",
    "Light",
    "LimitError",
    "Lines",
    "Look",
    "Mesh",
    "MissingExtraError",
    "Orientation",
    "Pass",
    "Picked",
    "Pointer",
    "Points",
    "RayProfile",
    "Renderer",
    "ScaleBar",
    "Scene",
    "ShaderError",
    "Stage",
    "StageError",
    "Surface",
    "TransferFunction",
    "ValueRangeError",
    "Vec2f",
    "Vec3f",
    "Vec4f",
    "Volume",
    "automatic",
    "automatic_channels",
    "camera",
    "devices",
    "driver",
    "edit",
    "explain",
    "export",
    "field",
    "first_picture",
    "fit_camera",
    "gradient",
    "integrate",
    "joint",
    "lighting",
    "load_scene",
    "modulation",
    "movie",
    "movies",
    "open",
    "param",
    "passes",
    "pick",
    "presets",
    "ray_profile",
    "reference",
    "register",
    "relight",
    "render",
    "samples",
    "save",
    "save_scene",
    "shade",
    "static",
    "statistics",
    "tone",
    "transfer",
    "transport",
    "view",
    "visibility",
    "warm_up",
]

# What loads the device or the readers is imported when it is first asked for.
_LAZY = {
    "Image": ("airlight.rendering.image", "Image"),
    "Picked": ("airlight.picking", "Picked"),
    "RayProfile": ("airlight.profiles", "RayProfile"),
    "Renderer": ("airlight.rendering.renderer", "Renderer"),
    "automatic": ("airlight.automatic", ""),
    "export": ("airlight.pages", "export"),
    "joint": ("airlight.joint", ""),
    "movie": ("airlight.movies", "movie"),
    "movies": ("airlight.movies", ""),
    "open": ("airlight.io", "open"),
    "pick": ("airlight.picking", "pick"),
    "save": ("airlight.io", "save"),
    "load_scene": ("airlight.scene_file", "load_scene"),
    "presets": ("airlight.transfer.presets", ""),
    "ray_profile": ("airlight.profiles", "ray_profile"),
    "reference": ("airlight.reference", ""),
    "samples": ("airlight.samples", ""),
    "save_scene": ("airlight.scene_file", "save_scene"),
    "view": ("airlight.viewer.showing", "view"),
}


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'airlight' has no attribute {name!r}")
    from importlib import import_module

    module, attribute = _LAZY[name]
    found = import_module(module)
    return getattr(found, attribute) if attribute else found
