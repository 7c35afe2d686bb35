"""Movies: turntables, ways between keyframes, and volumes over time, drawn frame by frame and encoded while drawing.

A movie is a list of scenes, one a frame (``Plan.scenes``), all known before the first is drawn: a frame drawn alone is that of
the movie.
"""

from __future__ import annotations

from .course import Plan, make_plan
from .keys import Keyframe, Keyframes, changes_of
from .making import Movie, movie
from .saving import load_keyframes, save_keyframes
from .turning import Turntable

__all__ = [
    "Keyframe",
    "Keyframes",
    "Movie",
    "Plan",
    "Turntable",
    "changes_of",
    "load_keyframes",
    "make_plan",
    "movie",
    "save_keyframes",
]
