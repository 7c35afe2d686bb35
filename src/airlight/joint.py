"""Functions of two and three variables, and the histograms that they are drawn on: what ``airlight.JointFunction`` is made of.

Axes and shapes are values; ``histogram`` counts the samples of a volume. See the guide's page on joint functions.
"""

from __future__ import annotations

from .transfer.histogram import JointHistogram
from .transfer.histogram import joint_histogram as histogram
from .transfer.joint_axes import Axis, Ramp
from .transfer.joint_shapes import Box, Ellipse, Polygon, Triangle

__all__ = ["Axis", "Box", "Ellipse", "JointHistogram", "Polygon", "Ramp", "Triangle", "histogram"]
