"""How well pictures are drawn while something moves: as well as there is time for, without going up and down."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..rendering.budget import Cost, scaled

TARGET_MS = 40.0
"""What a moving picture may take: with the one before it, which the pointer may have missed by little, less than 100 ms."""


@dataclass(frozen=True)
class Rung:
    """How a moving picture is drawn.

    Parameters
    ----------
    scale
        Of its width and height.
    step
        Least step in voxels; a document with a greater one keeps that.
    hurries
        Whether rays end early and slabs are lit in their middle (``hurried``).
    """

    scale: float
    step: float
    hurries: bool = False


# Of each next one, pictures of the CT head are worse and quicker. The last are for looks of which two voxels take too long.
RUNGS = (
    Rung(1.0, 0.0),
    Rung(0.75, 1.0),
    Rung(0.75, 1.5),
    Rung(0.5, 1.0),
    Rung(0.5, 1.5),
    Rung(0.5, 2.0, hurries=True),
    Rung(0.5, 3.0, hurries=True),
    Rung(0.5, 4.0, hurries=True),
)
FLOOR = 5
HALF = 3
HEAVY_MS = 250.0
"""What a picture at the floor must take before steps become larger than it has."""

TOO_SLOW, QUICK_ENOUGH = 1.25, 0.75  # of what a picture may take
SLOW_FRAMES = 2
HEAVY_FRAMES = 8
QUICK_FRAMES, MOST_QUICK_FRAMES = 8, 128

QUALITIES = (80, 60, 60)
"""Quality of JPEG; for slow links it is less, and for slower ones so is the picture."""

SLOW_LINK_MS, QUICK_LINK_MS = 80.0, 50.0
SLOW_TRIPS, QUICK_TRIPS = 4, 30


@dataclass(frozen=True)
class Pace:
    """Where on the ladder a view is, and what speaks for another rung.

    Attributes
    ----------
    rung
        Number of the rung.
    slow, quick
        So many pictures in a row took too long, or would be quick enough on a better rung.
    patience
        So many of the latter it takes; each step down doubles it, so that a view does not go up and down.
    link
        How far pictures are simplified for the connection: 0 to 2.
    slow_trips, quick_trips
        So many round trips in a row took too long, or little time.
    """

    rung: int = FLOOR
    slow: int = 0
    quick: int = 0
    patience: int = QUICK_FRAMES
    link: int = 0
    slow_trips: int = 0
    quick_trips: int = 0

    @property
    def quality(self) -> int:
        """Quality of JPEG."""
        return QUALITIES[self.link]

    def drawn(self, step: float) -> Rung:
        """How the next moving picture of a document with a step [voxels] is drawn."""
        rung = RUNGS[max(self.rung, HALF) if self.link == 2 else self.rung]
        return replace(rung, step=max(rung.step, step))


def after_frame(pace: Pace, cost: Cost, size_px: tuple[int, int], step: float) -> Pace:
    """Return the pace after a moving picture whose cost has been learnt.

    Parameters
    ----------
    cost
        What pictures of the view take.
    size_px
        Size of the view.
    step
        Of the document [voxels].
    """

    def expected(rung: int) -> float:
        width, height = scaled(size_px, RUNGS[rung].scale)
        return cost.of(width * height, max(RUNGS[rung].step, step))

    def best(most_ms: float, last: int) -> int:
        return next((rung for rung in range(last) if expected(rung) <= most_ms), last)

    if expected(pace.rung) > TOO_SLOW * TARGET_MS and pace.rung < FLOOR:
        if pace.slow + 1 < SLOW_FRAMES:
            return replace(pace, slow=pace.slow + 1, quick=0)
        return replace(pace, rung=best(TARGET_MS, FLOOR), slow=0, quick=0, patience=min(2 * pace.patience, MOST_QUICK_FRAMES))
    if expected(pace.rung) > HEAVY_MS and pace.rung < len(RUNGS) - 1:
        heavier = pace.slow + 1 >= HEAVY_FRAMES
        return replace(pace, rung=pace.rung + heavier, slow=0 if heavier else pace.slow + 1, quick=0)
    # What is heavy comes back to the floor once that takes less than half of what is too much.
    better = FLOOR if pace.rung > FLOOR and expected(FLOOR) <= HEAVY_MS / 2 else best(QUICK_ENOUGH * TARGET_MS, pace.rung)
    if better >= pace.rung:
        return replace(pace, slow=0, quick=0)
    if pace.quick + 1 < pace.patience:
        return replace(pace, slow=0, quick=pace.quick + 1)
    return replace(pace, rung=better, slow=0, quick=0)


def after_trip(pace: Pace, trip_ms: float) -> Pace:
    """Return the pace after a picture was shown so long after it was sent."""
    slow = pace.slow_trips + 1 if trip_ms > SLOW_LINK_MS else 0
    quick = pace.quick_trips + 1 if trip_ms < QUICK_LINK_MS else 0
    if slow >= SLOW_TRIPS and pace.link < len(QUALITIES) - 1:
        return replace(pace, link=pace.link + 1, slow_trips=0, quick_trips=0)
    if quick >= QUICK_TRIPS and pace.link > 0:
        return replace(pace, link=pace.link - 1, slow_trips=0, quick_trips=0)
    return replace(pace, slow_trips=slow, quick_trips=quick)


def at_rest(pace: Pace) -> Pace:
    """Return the pace of a view that has come to rest: another way is found quicker, as nothing is seen to flicker."""
    return replace(pace, slow=0, quick=0, patience=QUICK_FRAMES)


def learnt(cost: Cost | None, pixels: int, step: float, spent_ms: float) -> Cost:
    """Return what pictures take, after one of so many pixels; of the first, half is taken for samples one voxel apart."""
    if cost is None:
        frame_ms = min(8.0, spent_ms / 2)
        each_ms = max(spent_ms - frame_ms, 1e-3) / (pixels * (1 + 1 / step))
        return Cost(frame_ms, each_ms, each_ms)
    cost.learn(pixels, step, spent_ms)
    return cost
