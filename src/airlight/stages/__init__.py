"""The host half of each stage, one module a slot. Importing this package makes their names known."""

from __future__ import annotations

from . import (
    camera,
    driver,
    field,
    gradient,
    integrate,
    lighting,
    modulation,
    passes,
    region,
    shade,
    tone,
    transfer,
    transport,
    visibility,
)

__all__ = [
    "camera",
    "driver",
    "field",
    "gradient",
    "integrate",
    "lighting",
    "modulation",
    "passes",
    "region",
    "shade",
    "tone",
    "transfer",
    "transport",
    "visibility",
]
