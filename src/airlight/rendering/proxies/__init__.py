"""Proxy geometry: the polygons and pieces that a rasteriser draws in place of a volume; functions of arrays alone."""
