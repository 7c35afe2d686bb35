"""Bounding geometry: where rays meet the first block that holds something, and the last (Scharsach 2005, sections 6 and 7).

The faces between blocks that hold something and those that do not are rasterised twice, for the nearest and for the farthest of
each pixel. Rays that meet a face from inside before any other begin within a block: there the near plane leaves no hole.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import LimitError, StageError
from ..gpu import raster
from ..gpu.tiles import Tile
from ..shader.program import GroupUniforms, ProgramKey, Switches, build_program, stage_key
from ..stages.camera import Orthographic, Perspective
from ..volume import FloatArray, domain_index
from .rasterised import depths_between, skin_world
from .resources import DrawnLayer, layer_leaps, pack_uniforms

if TYPE_CHECKING:
    from .march import Band, MarchFrame

SIDES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (0, 4, 7, 3), (1, 2, 6, 5))
"""Corners of a cube's sides, low and high along z, y and x, anticlockwise as seen from outside."""
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])


def border_faces(active: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Return the faces between active blocks (z, y, x) and others, or the outside: corners (n, 4, 3) as x, y, z, in blocks.

    They look outwards, and close what is active: a ray from outside meets one from outside first.
    """
    padded = np.pad(active, 1)
    inside = (slice(1, -1),) * 3
    found = []
    for side, corners in enumerate(SIDES):
        axis, step = side // 2, 1 if side % 2 else -1
        beyond = np.roll(padded, -step, axis=axis)[inside]
        blocks = np.argwhere(active & ~beyond)[:, ::-1]
        found.append(blocks[:, None, :] + CORNERS[list(corners)])
    return np.concatenate(found)


def check_bounding(frame: MarchFrame) -> None:
    """Refuse bounding geometry where there is none.

    Raises
    ------
    StageError
        For cameras without a rasteriser's projection, single pixels, stages that show something even where all blocks are
        empty, and layers of whose blocks nothing is known.
    LimitError
        For images that are larger than a texture.
    """
    where, instead = 'skip "geometry"', "use skip='auto'"
    camera, integrate = frame.scene_stages["camera"], frame.scene_stages["integrate"]
    if not isinstance(camera, (Perspective, Orthographic)):
        raise StageError(where, f"cannot draw faces as {camera.name} cameras see them", instead)
    if frame.chosen is not None:
        raise StageError(where, "is for whole images", instead)
    if getattr(integrate, "fills", False) or any("leaps" not in layer.resources["field"] for layer in frame.layers):
        raise StageError(where, "knows of no blocks in which nothing is, for this look", instead)
    most = frame.device.limits["max-texture-dimension-2d"]
    if max(frame.size_px) > most:
        raise LimitError(where, f"draws images of at most {most} pixels a side, this one is {frame.size_px}", instead)


def faces_of(frame: MarchFrame, layer: DrawnLayer) -> FloatArray:
    """Triangles (t, 3, 3) in the device's world round the blocks of a layer that hold something."""
    leaps = layer_leaps(frame.device, layer)
    volume = layer.context.volume
    active = np.zeros(tuple(-(-n // leaps.group_voxels) for n in reversed(volume.size)), dtype=bool)
    x, y, z = leaps.groups.T
    active[z, y, x] = True
    faces = border_faces(active).astype(np.float64) * leaps.group_voxels
    low, high = domain_index(volume.size, layer.field.cells)
    skin_index = skin_world(frame) * np.linalg.norm(volume.index_from_world[:3, :3], axis=1)
    p_index = np.where(faces <= 0, low - skin_index, np.where(faces >= np.array(volume.size) - 1.0, high + skin_index, faces))
    p_world = p_index @ volume.world_from_index[:3, :3].T + volume.world_from_index[:3, 3] - frame.anchor_world
    corners = p_world[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3, 3)
    return corners if np.linalg.det(volume.world_from_index[:3, :3]) > 0 else corners[:, ::-1]


def reaches(frame: MarchFrame, band: Band) -> dict[str, Any]:
    """Textures of the distances at which the rays of a band meet the first and the last face, where they are asked for."""
    if frame.skip != "geometry":
        return {}
    check_bounding(frame)
    device, camera = frame.device, frame.scene_stages["camera"]
    triangles = np.concatenate([faces_of(frame, layer) for layer in frame.layers])
    near, far = depths_between(triangles.reshape(-1, 3), frame)
    keys = (("camera", stage_key(camera)),)
    program = build_program(ProgramKey("passes/bounding.wgsl", keys, (), (), ("group",), Switches(), device.traits))
    size = (frame.size_px[0], band.rows)
    part = band.uniforms(Tile(0, band.first_row, *size))
    values = {"camera": camera.uniforms(frame.layers[0].context), "group": GroupUniforms(0.0, 0.0, near, far)}
    data = pack_uniforms(program, part, values)
    first, last = raster.draw_extremes(device, program, size, triangles, data)
    return {"reach_first": first, "reach_last": last}
