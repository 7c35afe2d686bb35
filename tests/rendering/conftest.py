"""What the tests of rendering share beside the fixtures of all tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import pytest

from airlight import reference

MOST_TRUTHS = 256  # of some 100 kB each; the tests of one function lie closer together


@pytest.fixture(scope="session", autouse=True)
def _truths_are_computed_once() -> Iterator[None]:
    """Both kinds of devices are compared with one picture of the reference: the same scene is not computed twice.

    Scenes are values, so equal ones have equal pictures. What is no key (arrays of pixels) is computed each time.
    """
    with pytest.MonkeyPatch.context() as patch:
        for name in ("render", "converged"):
            patch.setattr(reference, name, _remembering(getattr(reference, name)))
        yield


def _remembering(draw: Callable[..., reference.ReferenceImage]) -> Callable[..., reference.ReferenceImage]:
    @lru_cache(maxsize=MOST_TRUTHS)
    def remembered(*scene: Any, **options: Any) -> reference.ReferenceImage:
        image = draw(*scene, **options)
        image.rgba.flags.writeable = image.depth.flags.writeable = False
        return image

    def drawn(*scene: Any, **options: Any) -> reference.ReferenceImage:
        try:
            return remembered(*scene, **options)
        except TypeError:
            return draw(*scene, **options)

    return drawn
