"""Transfer functions for hypothesis."""

from __future__ import annotations

from hypothesis import strategies as st

from airlight.transfer import TransferFunction
from airlight.transfer.colour import MOST_COLOUR

numbers = st.floats(0, 1, allow_subnormal=False).map(lambda x: round(x, 3))
colours = st.tuples(numbers, numbers, numbers)
values = st.lists(st.integers(-20, 20).map(float), min_size=1, max_size=6).map(sorted)


@st.composite
def functions(draw: st.DrawFn, associated: bool = False) -> TransferFunction:
    """Functions of a few points, some of them steps."""
    extinctions = numbers | st.just(0.0)
    return TransferFunction([(v, draw(colours), draw(extinctions)) for v in draw(values)], associated)


any_number = st.floats(allow_nan=False, allow_infinity=False)
any_extinction = st.floats(0, allow_infinity=False)


@st.composite
def any_functions(draw: st.DrawFn) -> TransferFunction:
    """Functions of any numbers at all."""
    places = draw(st.lists(any_number, min_size=1, max_size=5))
    associated = draw(st.booleans())
    # What media emit has no limit; the colour that they have has one.
    rgb = st.tuples(*[any_extinction if associated else st.floats(0, MOST_COLOUR)] * 3)
    return TransferFunction([(v, draw(rgb), draw(any_extinction)) for v in sorted(places)], associated)
