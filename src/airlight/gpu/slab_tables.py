"""Tables of slabs, made on the device."""

from __future__ import annotations

import numpy as np
import wgpu

from ..errors import LimitError
from ..shader.layout import fill
from ..shader.program import ProgramKey, SlabTableUniforms, Switches, build_program
from ..stage import SlabTable
from ..transfer.tables import segment_rows
from . import compute
from .device import Device

ROOT = "passes/slab_table.wgsl"
WINDOWS = 1 << 19  # of one dispatch, which cannot be cancelled: about 30 ms of one core of a software adapter
THREADS = 8  # of a diagonal
MOST_BYTES = 1 << 31


def make_slab_table(device: Device, table: SlabTable, root: str = ROOT) -> wgpu.GPUTexture:
    """Texture of a table: ``lengths`` layers, and as many again with the shares of the back when it is weighted.

    Raises
    ------
    LimitError
        When the table is larger than the device's textures, or than 2 GiB.
    """
    n, layers = table.entries, table.lengths * (2 if table.weighted else 1)
    most, where = device.limits["max-texture-dimension-2d"], "transfer.preintegrated.entries"
    if n > most:
        raise LimitError(where, f"is {n}; {device.info.name} holds at most {most} a side", "choose fewer")
    fitting = min(MOST_BYTES // (16 * n * n), device.limits["max-texture-array-layers"])
    if layers > fitting:
        found = f"is {n}, and {layers} such tables are too large together: at most {fitting} fit"
        raise LimitError(where, found, "choose fewer entries or lengths")
    usage = wgpu.TextureUsage
    texture = device.gpu.create_texture(
        size=(n, n, layers),
        format="rgba32float",
        usage=usage.TEXTURE_BINDING | usage.STORAGE_BINDING | usage.COPY_SRC,
    )
    fill_slab_table(device, table, texture, root)
    return texture


def fill_slab_table(device: Device, table: SlabTable, texture: wgpu.GPUTexture, root: str = ROOT) -> None:
    """Dispatch the program of a table for each of its lengths, some diagonals at a time."""
    n, planes = table.entries, 2 if table.weighted else 1
    at_once = min(n, max(1, WINDOWS // n))
    outputs = ("segments", "waiting", "slab_table_out")
    key = ProgramKey(root, (), (), outputs, ("slab_table",), Switches(weighted=table.weighted), device.traits)
    program = build_program(key)
    pipeline = compute.pipeline_of(device, program)
    record = np.zeros((), dtype=program.uniforms.dtype)
    member = next(m for m in program.uniforms.members if m.name == "slab_table")
    assert member.struct is not None
    bound = {
        "uniforms": compute.write_uniforms(device, "uniforms of slab table", record.tobytes()),
        "segments": compute.write_records(device, "segments", segment_rows(table.function, n)),
        # Two rows of four numbers a window, with a row of diagonals one longer than they are: see the shader.
        "waiting": compute.storage_buffer(device, "waiting", 32 * n * (at_once + 1) * planes),
        "slab_table_out": texture.create_view(dimension="2d-array"),
    }
    groups = compute.bind_groups(device, pipeline, bound)
    x, y = device.traits.workgroup
    for layer in range(table.lengths):
        for first in range(0, n, at_once):
            uniforms = SlabTableUniforms(
                entries=n,
                lengths=table.lengths,
                layer=layer,
                first_diagonal=first,
                diagonals=min(at_once, n - first),
                length_world=table.length * (layer + 1) / table.lengths,
                associated=table.function.associated,
            )
            fill(record[member.name], member.struct, uniforms)
            compute.write_uniforms(device, "uniforms of slab table", record.tobytes())
            compute.dispatch(device, pipeline, groups, (-(-THREADS // y), -(-uniforms.diagonals // x), 1))
