"""Messages as binary frames: count, lengths of all parts (uint32, little-endian), JSON, buffers."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any, NoReturn

from ...errors import ValueRangeError

MOST_PARTS = 9
MOST_DEPTH = 32


def packed(message: dict[str, Any], buffers: Sequence[bytes] = ()) -> bytes:
    """Return a message and its buffers as one frame."""
    text = json.dumps(message, allow_nan=False, separators=(",", ":")).encode()
    parts = [text, *buffers]
    return struct.pack(f"<{1 + len(parts)}I", len(parts), *(len(part) for part in parts)) + b"".join(parts)


def unpacked(frame: bytes) -> tuple[dict[str, Any], list[bytes]]:
    """Return the message and the buffers of a frame.

    Raises
    ------
    ValueRangeError
        When the frame is no message: lengths that do not add up, too many parts, no JSON object, or one nested too deeply.
    """
    try:
        (count,) = struct.unpack_from("<I", frame)
        if not 1 <= count <= MOST_PARTS:
            raise ValueError(f"it has {count} parts")
        lengths = struct.unpack_from(f"<{count}I", frame, 4)
        if 4 * (1 + count) + sum(lengths) != len(frame):
            raise ValueError("its lengths do not add up")
        at, parts = 4 + 4 * count, []
        for length in lengths:
            parts.append(frame[at : at + length])
            at += length
        message = json.loads(parts[0], parse_constant=_refused)
        if not isinstance(message, dict) or not _is_shallow(message):
            raise ValueError("it is no object, or a deep one")
    except (struct.error, ValueError, RecursionError) as error:
        raise ValueRangeError("message", f"is none ({error})"[:200]) from None
    return message, parts[1:]


def _refused(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON")


def _is_shallow(value: Any) -> bool:
    level = [value]
    for _ in range(MOST_DEPTH):
        level = [inner for part in level for inner in (part.values() if isinstance(part, dict) else part)]
        level = [part for part in level if isinstance(part, (dict, list))]
        if not level:
            return True
    return False
