"""Structs that host and device share: places by the rules of WGSL, and an echo from the device."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import wgpu
from hypothesis import given, settings
from hypothesis import strategies as st

from airlight.errors import StageError
from airlight.gpu.device import open_device
from airlight.shader.layout import LEAF_TYPES, Struct, class_struct, fill, make_struct, pack, size_in
from airlight.stage import F32, Mat3f, Vec3f, param

LEAVES = sorted(LEAF_TYPES)


def test_alignment_of_the_specification():
    """The example of the WGSL specification, section 14.4.1: struct A and B."""
    a = make_struct("A", [("u", "f32", ""), ("v", "f32", ""), ("w", "vec2f", ""), ("x", "f32", "")])
    assert [m.offset for m in a.members] == [0, 4, 8, 16]
    assert (a.size, a.alignment) == (24, 8)
    b = make_struct("B", [("a", "vec2f", ""), ("b", "vec3f", ""), ("c", "f32", ""), ("d", "f32", "")])
    assert [m.offset for m in b.members] == [0, 16, 28, 32]
    assert b.size == 48


def test_units_and_offsets_are_told_in_the_text():
    struct = make_struct("P", [("step", "f32", "world"), ("size", "vec3f", "voxel")])
    assert "step: f32,  // [world] offset 0" in struct.wgsl
    assert "size: vec3f,  // [voxel] offset 16" in struct.wgsl


def test_unknown_type_is_refused():
    with pytest.raises(StageError, match=r"P\.x has the unknown WGSL type 'f64'"):
        make_struct("P", [("x", "f64", "")])


def test_matrices_are_transposed_in_pack():
    @dataclass(frozen=True, eq=False)
    class P:
        m: Mat3f = param(None)
        v: Vec3f = param((0, 0, 0))
        s: F32 = param(0.0)

    P.__annotations__ = {"m": Mat3f, "v": Vec3f, "s": F32}
    matrix = np.arange(9.0).reshape(3, 3)
    data = np.frombuffer(pack(class_struct(P, "P"), P(matrix, (7, 8, 9), 5)), np.float32)
    assert data[:12].reshape(3, 4)[:, :3].tolist() == matrix.T.tolist()
    assert data[12:16].tolist() == [7, 8, 9, 5]


@st.composite
def structs(draw, depth: int = 1) -> Struct:
    kinds = draw(st.lists(st.sampled_from(LEAVES), min_size=1, max_size=6))
    members: list = [(f"m{i}", kind, "") for i, kind in enumerate(kinds)]
    if depth and draw(st.booleans()):
        inner = draw(structs(depth=depth - 1))
        members.insert(draw(st.integers(0, len(members))), ("inner", inner, ""))
    return make_struct(f"S{depth}", members)


@pytest.fixture(scope="module")
def device():
    opened = open_device()
    yield opened
    opened.close()


def leaves(struct: Struct, path: str = "u"):
    """(WGSL expression, index into the record, component type) of each scalar of a struct."""
    for m in struct.members:
        here = f"{path}.{m.name}"
        if m.struct:
            yield from ((e, (m.name, *i), t) for e, i, t in leaves(m.struct, here))
        elif m.type.startswith("mat"):
            columns, rows = int(m.type[3]), int(m.type[5])
            yield from ((f"{here}[{c}][{r}]", (m.name, c, r), "f32") for c in range(columns) for r in range(rows))
        elif m.type.startswith("vec"):
            kind = {"f": "f32", "i": "i32", "u": "u32"}[m.type[-1]]
            yield from ((f"{here}[{c}]", (m.name, c), kind) for c in range(int(m.type[3])))
        else:
            yield here, (m.name,), m.type


@settings(max_examples=25)
@given(struct=structs(), seed=st.integers(0, 2**32 - 1))
def test_echo_from_the_device(device, struct, seed):
    """Whatever is packed on the host arrives, member by member, in a shader that reads the generated struct."""
    rng = np.random.default_rng(seed)
    record = np.zeros((), dtype=struct.dtype)
    scalars = list(leaves(struct))
    sent = rng.integers(0, 1 << 20, len(scalars))
    for (_, index, _), value in zip(scalars, sent, strict=True):
        target = record
        for name in index[:-1]:
            target = target[name]
        target[index[-1]] = value
    nested = [m.struct.wgsl for m in struct.members if m.struct]
    lines = [f"  out[{i}] = u32({e});" for i, (e, _, _) in enumerate(scalars)]
    text = "\n".join(
        [
            *nested,
            struct.wgsl,
            f"@group(0) @binding(0) var<uniform> u: {struct.name};",
            "@group(0) @binding(1) var<storage, read_write> out: array<u32>;",
            "@compute @workgroup_size(1) fn main() {",
            *lines,
            "}",
        ]
    )
    assert echo(device, text, record.tobytes(), len(scalars)).tolist() == sent.tolist()


def echo(device, text: str, data: bytes, count: int) -> np.ndarray:
    gpu, usage = device.gpu, wgpu.BufferUsage
    size = -(-len(data) // 16) * 16
    uniform = gpu.create_buffer_with_data(data=data.ljust(size, b"\0"), usage=usage.UNIFORM)
    out = gpu.create_buffer(size=4 * count, usage=usage.STORAGE | usage.COPY_SRC)
    pipeline = gpu.create_compute_pipeline(
        layout="auto", compute={"module": gpu.create_shader_module(code=text), "entry_point": "main"}
    )
    group = gpu.create_bind_group(
        layout=pipeline.get_bind_group_layout(0),
        entries=[{"binding": 0, "resource": {"buffer": uniform}}, {"binding": 1, "resource": {"buffer": out}}],
    )
    encoder = gpu.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, group)
    compute.dispatch_workgroups(1)
    compute.end()
    gpu.queue.submit([encoder.finish()])
    return np.frombuffer(gpu.queue.read_buffer(out), np.uint32)


def test_nested_values_are_filled():
    inner = make_struct("I", [("a", "f32", "")])
    outer = make_struct("O", [("x", "f32", ""), ("i", inner, ""), ("y", "f32", "")])
    assert [m.offset for m in outer.members] == [0, 16, 32]
    assert outer.wgsl.count("@align(16)") == 2

    class Inner:
        a = 2.0

    class Outer:
        x, i, y = 1.0, Inner, 3.0

    record = np.zeros((), dtype=outer.dtype)
    fill(record, outer, Outer)
    assert np.frombuffer(record.tobytes(), np.float32)[[0, 4, 8]].tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        ("f32", 12),
        ("vec3f", 32),
        ("vec3<f32>", 32),
        ("vec2<u32>", 24),
        ("mat3x3<f32>", 80),
        ("array<vec4<f32>, 3>", 80),
        ("array<array<f32, 4>, 3u>", 56),
        ("array<vec3f, 2>", 64),
        ("Two", 32),
        ("bool", None),
    ],
)
def test_sizes_of_structs_that_are_declared(kind, size):
    """What a stage keeps of a ray, however its types are written."""
    text = f"struct Two {{ a: f32, b: vec2f }} // struct A {{ a: f32 }}\nstruct A {{ a: f32, b: {kind}, c: f32 }}"
    if size is None:
        with pytest.raises(StageError, match="cannot be kept in a buffer"):
            size_in(text, "A")
    else:
        assert size_in(text, "A") == size
