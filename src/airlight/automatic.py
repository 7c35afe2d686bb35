"""Transfer functions that are made of the data: of the boundaries between materials, or of the value at a picked point."""

from __future__ import annotations

from .transfer.automatic import boundary_function, boundary_joint_function, peak_at
from .transfer.boundary import Boundary, boundaries

__all__ = ["Boundary", "boundaries", "boundary_function", "boundary_joint_function", "peak_at"]
