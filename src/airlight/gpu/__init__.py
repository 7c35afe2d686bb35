"""Everything that touches the device; the only room that imports wgpu."""
