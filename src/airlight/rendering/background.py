"""The pass that puts an environment behind a scene, before its tones are mapped."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..environment import Environment
from ..environment.background import background_picture, is_reduced
from ..geometry import Mesh
from ..gpu import compute
from ..scene import Layer, Look, Scene
from ..shader.program import ProgramKey, Switches, build_program, stage_key
from ..stage import Stage
from ..stages.environment import Background
from ..transfer import TransferFunction
from ..volume import Volume
from .resources import bound_resources, pack_uniforms, uniform_values

if TYPE_CHECKING:
    from .march import MarchFrame

BLACK = (0.0, 0.0, 0.0)


def plain_background(scene: Scene) -> tuple[float, float, float] | None:
    """Colour that lies behind the finished image: any where an environment covers it all."""
    return BLACK if isinstance(scene.background, Environment) else scene.background


def background_statistics(scene: Scene) -> dict[str, Any]:
    """What ``image.stats`` says of an environment behind the scene: its picture, and whether a finer one was reduced."""
    if not isinstance(scene.background, Environment):
        return {}
    source = scene.background.source
    height, width = background_picture(source).shape[1:3]
    return {"background": {"environment": source.kind, "picture": [width - 2, height], "reduced": is_reduced(source)}}


def without_layers(scene: Scene) -> Scene:
    """Scene of which nothing is seen but background and meshes: its first layer, or a voxel round the meshes, made empty."""
    layer = scene.layers[0] if scene.layers else _voxel(scene)
    look = Look(shade=layer.look.shade if scene.meshes else "none", tone=layer.look.tone)
    empty = Layer(layer.volume, TransferFunction([(0.0, "black", 0.0)]), look)
    cuts_meshes = any(isinstance(shape, Mesh) and shape.clipped for shape in scene.meshes)
    return replace(scene, layers=(empty,), clips=scene.clips if cuts_meshes else ())


def _voxel(scene: Scene) -> Layer:
    corners = np.concatenate([shape.corners_world for shape in scene.meshes])
    low, high = corners.min(axis=0), corners.max(axis=0)
    # Not much smaller than its distance from the eye, which is told in steps of it.
    far = 0.0 if isinstance(scene.camera, str) else 1e-3 * math.dist(scene.camera.eye, (low + high) / 2)
    size = max(float((high - low).max()), far, 1e-6 * float(np.abs(corners).max()), 1e-9)
    return Layer(Volume(np.zeros((1, 1, 1), dtype=np.float32), spacing=(size,) * 3, origin=tuple((low + high) / 2)))


def put_behind(frame: MarchFrame, bands: Iterable[Any]) -> None:
    """Add what is seen of the environment to the radiance of bands of rows, which are opaque then."""
    assert isinstance(frame.scene.background, Environment)
    device = frame.device
    stages: dict[str, Stage] = {"camera": frame.scene_stages["camera"], "background": Background(frame.scene.background)}
    resources = {slot: stage.resources(frame.layers[0].context) for slot, stage in stages.items()}
    keys = tuple((slot, stage_key(stage, resources[slot])) for slot, stage in stages.items())
    program = build_program(ProgramKey("passes/background.wgsl", keys, (), ("radiance",), (), Switches(), device.traits))
    pipeline = compute.pipeline_of(device, program)
    values = uniform_values(device, stages, frame.layers, frame.anchor_world, frame.progress)
    views = bound_resources(device, program, frame.layers, resources, frame.anchor_world, frame.progress)
    for band in bands:
        data = pack_uniforms(program, band.uniforms(), values)
        bound = {**views, "radiance": band.radiance, "uniforms": compute.write_uniforms(device, "uniforms of background", data)}
        groups = compute.bind_groups(device, pipeline, bound)
        compute.dispatch_pixels(device, pipeline, groups, frame.size_px[0], band.rows)
