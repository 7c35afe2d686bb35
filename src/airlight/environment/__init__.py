"""Light from all directions: environments as values, their pictures, and the maps that surfaces are lit by."""

from __future__ import annotations

from .value import BUILT_IN, Environment, Opener

__all__ = ["BUILT_IN", "Environment", "Opener"]
