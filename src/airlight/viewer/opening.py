"""Opening volumes in a viewer: in the place of what is shown, or as a further layer."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..errors import ValueRangeError
from ..first_picture import first_picture, resolve
from ..scene import Layer, Look, Scene
from ..transfer import TransferFunction
from ..volume import Volume
from .document import Document

WAYS = ("replace", "layer")


def opened(document: Document, volume: Volume, way: str, size_px: tuple[int, int]) -> Document:
    """Return a document that shows a volume: ``"replace"`` alone, in a good first picture, ``"layer"`` beside what is there.

    Raises
    ------
    ValueRangeError
        For other ways.
    """
    if way not in WAYS:
        raise ValueRangeError("way", f"is {way!r:.40}, must be one of {', '.join(WAYS)}")
    if way == "replace" or is_nothing(document):
        return replace(document, scene=resolve(first_picture(volume, size_px), size_px))
    scene = document.scene
    look, clips = (scene.layers[0].look, scene.layers[0].clips) if scene.layers else (Look(), ())
    layer = Layer(volume, None, look, clips=clips)
    return replace(document, scene=resolve(replace(scene, layers=(*scene.layers, layer)), size_px))


def nothing() -> Document:
    """Return the document of a viewer that waits for a file: a volume in which nothing is seen."""
    clear = TransferFunction([(0.0, "black", 0.0), (1.0, "white", 0.0)])
    return Document(Scene(_nowhere(), transfer=clear))


def is_nothing(document: Document) -> bool:
    """Whether a document shows nothing but that."""
    layers = document.scene.layers
    return len(layers) == 1 and layers[0].volume is _nowhere()


@lru_cache(maxsize=1)
def _nowhere() -> Volume:
    return Volume(np.zeros((2, 2, 2), np.uint8))
