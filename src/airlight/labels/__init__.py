"""Labels of regions: a volume of whole numbers beside an image, and the styles in which its regions are drawn."""

from __future__ import annotations

from .dense import LabelNumbers, label_numbers
from .style import LabelStyle
from .table import drawn_labels, styles_table
from .value import Labels

__all__ = ["LabelNumbers", "LabelStyle", "Labels", "drawn_labels", "label_numbers", "styles_table"]
