"""Geometry that shares its depth with volumes: meshes, lines and points."""

from .marks import Lines as Lines
from .marks import Points as Points
from .mesh import Mesh as Mesh
