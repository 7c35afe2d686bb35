"""Pipelines of linked programs, their bind groups and dispatches."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
import wgpu

from ..errors import ShaderError
from ..shader.program import ARRAYS, Binding, Program
from .device import Device

GROUPS = 4
WRITTEN = ("buffer", "storage_texture")  # kinds of bindings
ROOMY = 4
PATIENCE_FRAMES = 1000
"""So many frames long buffers are kept that are more than so many times as large as what is asked for."""


@dataclass(frozen=True, eq=False)
class Pipeline:
    """A compiled program with the layouts of its bind groups."""

    program: Program
    pipeline: Any
    layouts: tuple[Any, ...]
    bytes: ClassVar[int] = 4 << 20  # about what a lit march takes on lavapipe


def pipeline_of(device: Device, program: Program) -> Pipeline:
    """Compile a program, or return it from the cache.

    Raises
    ------
    ShaderError
        With file and line of the WGSL at fault, and the compiler's words.
    """
    found: Pipeline = device.kept.get(("pipeline", program.key), lambda: _compile(device, program))
    return found


def _compile(device: Device, program: Program) -> Pipeline:
    def make(module: Any, layout: Any) -> Any:
        return device.gpu.create_compute_pipeline(layout=layout, compute={"module": module, "entry_point": "main"})

    return compiled(device, program, wgpu.ShaderStage.COMPUTE, make)


def compiled(device: Device, program: Program, seen_by: int, make: Callable[[Any, Any], Any]) -> Pipeline:
    """Compile a program for stages of a pipeline; ``make`` is given its module and the layout of its bind groups.

    Raises
    ------
    ShaderError
        With file and line of the WGSL at fault, and the compiler's words.
    """
    layouts = layouts_of(device, program, seen_by)
    try:
        module = device.gpu.create_shader_module(code=program.linked.text)
        pipeline = make(module, device.gpu.create_pipeline_layout(bind_group_layouts=layouts))
    except wgpu.GPUError as error:
        raise shader_error(program, str(error)) from error
    return Pipeline(program, pipeline, layouts)


def layouts_of(device: Device, program: Program, seen_by: int) -> tuple[Any, ...]:
    """Layouts of the bind groups of a program, for these stages of a pipeline; vertices write nothing but themselves."""
    layouts = []
    for group in range(GROUPS):
        entries = [
            layout_entry(device, b) | {"visibility": seen_by & ~(wgpu.ShaderStage.VERTEX if b.kind in WRITTEN else 0)}
            for b in program.bindings
            if b.group == group
        ]
        layouts.append(device.gpu.create_bind_group_layout(entries=entries))
    return tuple(layouts)


def shader_error(program: Program, message: str) -> ShaderError:
    """Error of the compiler, with its positions mapped back to files and lines."""
    explained = program.linked.explain_message(message)
    first = next((w for w in explained.replace("┌─ ", "\n").split() if w.count(":") == 2 and ".wgsl" in w), "")
    return ShaderError(first or str(program.key.root), "does not compile\n" + explained)


def layout_entry(device: Device, binding: Binding) -> dict[str, Any]:
    """Entry of a binding in the layout of its group, for any stage of a pipeline."""
    entry: dict[str, Any] = {"binding": binding.index}
    match binding.kind:
        case "uniform" | "lights":
            entry["buffer"] = {"type": "uniform"}
        case "read":
            entry["buffer"] = {"type": "read-only-storage"}
        case "buffer":
            entry["buffer"] = {"type": "storage"}
        case "storage_texture":
            shape, _, rest = binding.type.removeprefix("texture_storage_").partition("<")
            dimension = shape.replace("_", "-")
            entry["storage_texture"] = {"access": "write-only", "format": rest.split(",")[0], "view_dimension": dimension}
        case "table" | "layers" | "loaded_grid" | "loaded_stack":
            kind = "float" if device.traits.filters_float32 else "unfilterable-float"
            entry["texture"] = {"sample_type": kind, "view_dimension": "2d-array" if binding.kind in ARRAYS else "3d"}
        case "numbers_2d" | "depth_2d":
            entry["texture"] = {"sample_type": "uint" if binding.kind == "numbers_2d" else "depth", "view_dimension": "2d"}
        case "filtered_2d" | "loaded_2d":
            kind = "float" if binding.kind == "filtered_2d" else "unfilterable-float"
            entry["texture"] = {"sample_type": kind, "view_dimension": "2d"}
        case "labels":
            entry["texture"] = {"sample_type": "uint", "view_dimension": "3d"}
        case "grid" | "stack" | "gradients" | "openness" | "filtered":
            entry["texture"] = {"sample_type": "float", "view_dimension": "2d-array" if binding.kind in ARRAYS else "3d"}
        case "sampler":
            entry["sampler"] = {"type": "filtering"}
    return entry


def bind_groups(device: Device, pipeline: Pipeline, resources: Mapping[str, Any]) -> list[Any]:
    """Bind groups 0 to 3; ``resources`` maps the names of bindings to buffers, texture views and samplers."""
    groups = []
    for group, layout in enumerate(pipeline.layouts):
        entries = []
        for binding in pipeline.program.bindings:
            if binding.group == group:
                resource = resources[binding.name]
                bound = {"buffer": resource} if isinstance(resource, wgpu.GPUBuffer) else resource
                entries.append({"binding": binding.index, "resource": bound})
        groups.append(device.gpu.create_bind_group(layout=layout, entries=entries))
    return groups


def dispatch(device: Device, pipeline: Pipeline, groups: list[Any], counts: tuple[int, int, int]) -> None:
    """Submit one dispatch of workgroups."""
    encoder = device.gpu.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline.pipeline)
    for number, group in enumerate(groups):
        compute.set_bind_group(number, group)
    compute.dispatch_workgroups(*counts)
    compute.end()
    device.queue.submit([encoder.finish()])


def dispatch_pixels(device: Device, pipeline: Pipeline, groups: list[Any], width_px: int, height_px: int) -> None:
    """Submit one dispatch with a thread for each pixel."""
    dispatch(device, pipeline, groups, workgroups(device, width_px, height_px))


def workgroups(device: Device, columns: int, rows: int, layers: int = 1) -> tuple[int, int, int]:
    """Counts of workgroups that have a thread for each of so many columns, rows and layers."""
    x, y = device.traits.workgroup
    return -(-columns // x), -(-rows // y), layers


def clear(device: Device, target: Any) -> None:
    """Fill a buffer with zeros."""
    encoder = device.gpu.create_command_encoder()
    encoder.clear_buffer(target)
    device.queue.submit([encoder.finish()])


def repeat(device: Device, row: npt.NDArray[Any], count: int, target: Any, first_byte: int = 0) -> None:
    """Fill bytes of a buffer with a row so many times, from a buffer that is kept for the next frame."""
    usage = wgpu.BufferUsage

    def make() -> Any:
        made = device.gpu.create_buffer(size=row.nbytes * count, usage=usage.COPY_SRC | usage.COPY_DST)
        device.queue.write_buffer(made, 0, np.tile(row, count))
        return made

    source = device.kept.get(("repeated", row.tobytes(), count), make)
    encoder = device.gpu.create_command_encoder()
    encoder.copy_buffer_to_buffer(source, 0, target, first_byte, row.nbytes * count)
    device.queue.submit([encoder.finish()])


def read_into(device: Device, parts: Sequence[tuple[Any, npt.NDArray[Any]]]) -> None:
    """Read what buffers begin with into contiguous arrays, all at once where one buffer takes it."""
    sizes = [array.nbytes for _, array in parts]
    if len(parts) > 1 and sum(sizes) > device.limits["max-buffer-size"]:
        for part in parts:
            read_into(device, [part])
        return
    usage = wgpu.BufferUsage
    mapped = buffer(device, "read back", sum(sizes), usage.MAP_READ | usage.COPY_DST)
    places = np.cumsum([0, *sizes])[:-1].tolist()
    encoder = device.gpu.create_command_encoder()
    for (source, _), place, size in zip(parts, places, sizes, strict=True):
        encoder.copy_buffer_to_buffer(source, 0, mapped, place, size)
    device.queue.submit([encoder.finish()])
    mapped.map_sync("READ", 0, sum(sizes))
    try:
        for (_, array), place, size in zip(parts, places, sizes, strict=True):
            array.reshape(-1).view(np.uint8)[:] = np.frombuffer(mapped.read_mapped(place, size, copy=False), np.uint8)
    finally:
        mapped.unmap()


def buffer(device: Device, name: Hashable, size: int, usage: int) -> Any:
    """Buffer of at least a size, kept by name for the next frame.

    Frames of a view that moves and rests need much and little in turn. One that is far too large is kept for a while all the
    same: buffers that are given back and taken again between the tables of edits leave holes in the device's memory.
    """
    key, kept = ("buffer", name), device.kept
    found = kept.find(key)
    if found is None or found.size <= ROOMY * size:
        device.needed_at[name] = kept.frame
    if found is not None and (found.size < size or kept.frame - device.needed_at[name] > PATIENCE_FRAMES):
        kept.drop(key)
        device.needed_at[name] = kept.frame
    return kept.get(key, lambda: device.gpu.create_buffer(size=-(-size // 16) * 16, usage=usage))


def storage_buffer(device: Device, name: Hashable, size: int) -> Any:
    """Buffer that passes write and the host reads back."""
    usage = wgpu.BufferUsage
    return buffer(device, name, size, usage.STORAGE | usage.COPY_SRC | usage.COPY_DST)


def write_uniforms(device: Device, name: str, data: bytes) -> Any:
    """Uniform buffer with this content."""
    usage = wgpu.BufferUsage
    target = buffer(device, name, len(data), usage.UNIFORM | usage.COPY_DST)
    device.queue.write_buffer(target, 0, data)
    return target


def write_records(device: Device, name: Hashable, rows: npt.NDArray[np.float32]) -> Any:
    """Storage buffer of a pass with these rows."""
    target = storage_buffer(device, name, rows.nbytes)
    device.queue.write_buffer(target, 0, np.ascontiguousarray(rows))
    return target


def write_storage(device: Device, name: str, data: bytes) -> Any:
    """Storage buffer for reading, with this content."""
    usage = wgpu.BufferUsage
    target = buffer(device, name, len(data), usage.STORAGE | usage.COPY_DST)
    device.queue.write_buffer(target, 0, data)
    return target


def linear_sampler(device: Device) -> Any:
    """Sampler that interpolates, between levels, too, and clamps to the edge."""
    filters = {"mag_filter": "linear", "min_filter": "linear", "mipmap_filter": "linear"}
    return device.kept.get(("sampler",), lambda: device.gpu.create_sampler(**filters))
