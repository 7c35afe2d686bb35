"""Structs that host and device share: dataclass fields to a WGSL struct and a NumPy dtype, in the order of the class.

The rules of alignment are those of the WGSL specification, sections 14.4.1 and 14.4.4 (alignment and size, and structs inside
uniform buffers, which start at multiples of 16 bytes).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import StageError
from ..stage import uniform_fields

_SCALARS = {"f32": "<f4", "i32": "<i4", "u32": "<u4"}


def _leaf_types() -> dict[str, tuple[int, int, str, tuple[int, ...]]]:
    """WGSL type: (alignment, size, scalar dtype, shape in memory)."""
    known: dict[str, tuple[int, int, str, tuple[int, ...]]] = {}
    for scalar, dtype in _SCALARS.items():
        letter = scalar[0]
        known[scalar] = (4, 4, dtype, ())
        for n in (2, 3, 4):
            known[f"vec{n}{letter}"] = (8 if n == 2 else 16, 4 * n, dtype, (n,))
    # Matrices of two rows are left out: with them in a uniform struct, pipelines lose the device (wgpu 0.32 on Mesa 22.3).
    for columns in (2, 3, 4):
        for rows in (3, 4):
            known[f"mat{columns}x{rows}f"] = (16, 16 * columns, "<f4", (columns, 4))
    return known


LEAF_TYPES = _leaf_types()


@dataclass(frozen=True)
class Member:
    """One member of a struct: its place in bytes and what it holds; ``struct`` for a nested one.

    ``aligned`` members say that they start at a multiple of 16: nested structs, and what follows one.
    """

    name: str
    type: str
    unit: str
    offset: int
    size: int
    struct: Struct | None = None
    aligned: bool = False


@dataclass(frozen=True)
class Struct:
    """A struct of WGSL with its place in memory."""

    name: str
    members: tuple[Member, ...]
    alignment: int
    size: int

    @property
    def wgsl(self) -> str:
        """Declaration, with unit and offset of each member as a comment."""
        lines = [f"struct {self.name} {{"]
        for m in self.members:
            align = "@align(16) " if m.aligned else ""
            unit = f"[{m.unit}] " if m.unit else ""
            lines.append(f"  {align}{m.name}: {m.type},  // {unit}offset {m.offset}")
        return "\n".join([*lines, "}"])

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """NumPy dtype with the same places."""
        formats: list[Any] = []
        for m in self.members:
            if m.struct:
                formats.append(m.struct.dtype)
            else:
                _, _, scalar, shape = LEAF_TYPES[m.type]
                formats.append((scalar, shape) if shape else scalar)
        return np.dtype(
            {
                "names": [m.name for m in self.members],
                "formats": formats,
                "offsets": [m.offset for m in self.members],
                "itemsize": self.size,
            }
        )


def make_struct(name: str, members: Sequence[tuple[str, str | Struct, str]]) -> Struct:
    """Lay out ``(name, type or nested struct, unit)`` in order.

    Raises
    ------
    StageError
        For types that WGSL does not know.
    """
    placed: list[Member] = []
    end, alignment = 0, 4
    for member, kind, unit in members:
        if isinstance(kind, Struct):
            align, size, text, nested = max(16, kind.alignment), _round_up(kind.size, 16), kind.name, kind
        elif kind in LEAF_TYPES:
            (align, size, _, _), text, nested = LEAF_TYPES[kind], kind, None
        else:
            raise StageError(f"{name}.{member}", f"has the unknown WGSL type {kind!r}", "use one of " + ", ".join(LEAF_TYPES))
        aligned = nested is not None or bool(placed and placed[-1].struct)
        align = max(align, 16) if aligned else align
        offset = _round_up(end, align)
        placed.append(Member(member, text, unit, offset, size, nested, aligned))
        end, alignment = offset + size, max(alignment, align)
    return Struct(name, tuple(placed), alignment, _round_up(max(end, 4), alignment))


@lru_cache(maxsize=256)
def class_struct(cls: type, name: str) -> Struct:
    """Struct of a dataclass whose fields carry WGSL types."""
    return make_struct(name, uniform_fields(cls))


def fill(record: npt.NDArray[Any], struct: Struct, value: Any) -> None:
    """Write the fields of a dataclass into a record of the struct's dtype. Matrices are transposed here and nowhere else."""
    for m in struct.members:
        field = getattr(value, m.name)
        if m.struct:
            fill(record[m.name], m.struct, field)
        elif m.type.startswith("mat"):
            matrix = np.asarray(field, dtype=np.float64).T
            record[m.name][..., : matrix.shape[1]] = matrix
        else:
            record[m.name] = field


def pack(struct: Struct, value: Any) -> bytes:
    """Bytes of one value of the struct."""
    record = np.zeros((), dtype=struct.dtype)
    fill(record, struct, value)
    return record.tobytes()


@lru_cache(maxsize=64)
def size_in(text: str, name: str) -> int:
    """Bytes of a struct that a linked text declares, as an element of an array.

    Raises
    ------
    StageError
        For types without a size of their own.
    """
    code = re.sub(r"\b(vec[234]|mat[234]x[234])<\s*([fiu])32\s*>", r"\1\2", re.sub(r"//[^\n]*", "", text))
    aliases = dict(re.findall(r"\balias\s+(\w+)\s*=\s*([^;]+);", code))
    structs = dict(re.findall(r"\bstruct\s+(\w+)\s*\{([^}]*)\}", code))

    def measure(kind: str) -> tuple[int, int]:
        kind = kind.strip()
        if kind in aliases:
            return measure(aliases[kind])
        if kind in LEAF_TYPES:
            return LEAF_TYPES[kind][:2]
        array = re.fullmatch(r"array<(.+),\s*(\d+)u?>", kind)
        if array:
            alignment, size = measure(array[1])
            return alignment, int(array[2]) * _round_up(size, alignment)
        if kind not in structs:
            raise StageError(f"struct {name}", f"holds a {kind}, which cannot be kept in a buffer", "use f32, u32 or vectors")
        end, widest = 0, 4
        for _, member in re.findall(r"(\w+)\s*:\s*((?:[^,<]|<(?:[^<>]|<[^<>]*>)*>)+)", structs[kind]):
            alignment, size = measure(member)
            end, widest = _round_up(end, alignment) + size, max(widest, alignment)
        return widest, _round_up(end, widest)

    alignment, size = measure(name)
    return _round_up(size, alignment)


def _round_up(number: int, multiple: int) -> int:
    return -(-number // multiple) * multiple
