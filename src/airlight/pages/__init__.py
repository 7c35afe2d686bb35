"""Pages to send: one HTML file that draws a volume in any browser with WebGPU, by the same WGSL files."""

from .exporting import Exported, export

__all__ = ["Exported", "export"]
