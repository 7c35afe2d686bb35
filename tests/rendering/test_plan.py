"""Plans of frames: order, ownership, types, and what is left out. Without a device."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from airlight import StageError
from airlight.handed import COLOUR, DEPTH, NUMBER, PerPixel
from airlight.rendering.plan import Step, in_order, planned

GREY = PerPixel("f32")
WANTED = {"radiance": COLOUR}


def step(name: str, reads: str = "", writes: str = "", **kinds) -> Step:
    known = {"radiance": COLOUR, "depth": DEPTH, "luminance": NUMBER} | kinds
    return Step(name, *({n: known.get(n, GREY) for n in names.split()} for names in (reads, writes)), lambda: None)


DRAWN = step("march", "", "radiance depth")


def test_what_nobody_reads_is_left_out_with_all_that_it_alone_needs():
    steps = [DRAWN, step("a", "depth", "a"), step("b", "a", "b"), step("c", "radiance", "radiance"), step("d", "c", "d")]
    kept = planned([*steps[:4], step("e", "radiance", "c"), steps[4]], WANTED)
    assert [one.name for one in kept] == ["march", "c"]
    assert [one.name for one in planned([*steps[:3], step("x", "radiance b", "radiance")], WANTED)] == ["march", "a", "b", "x"]


def test_a_name_that_is_written_anew_makes_what_was_before_idle():
    with pytest.raises(StageError, match="pass 'again' writes 'radiance', which belongs to pass 'march'"):
        planned([DRAWN, step("again", "depth", "radiance")], WANTED)


REFUSED = [
    ([DRAWN, step("a", "b radiance", "radiance")], "pass 'a' reads 'b', which no pass writes"),
    (
        [DRAWN, step("a", "b radiance", "radiance"), step("b", "", "b")],
        "pass 'a' reads 'b', which only pass 'b' writes, behind it",
    ),
    (
        [DRAWN, step("a", "", "a"), step("b", "a radiance", "radiance", a=NUMBER)],
        "pass 'b' reads 'a' as a number of the whole image, and pass 'a'",
    ),
    ([DRAWN, step("a", "", "a"), step("b", "", "a")], "pass 'b' writes 'a', which belongs to pass 'a'"),
    (
        [step("a", "", "radiance", radiance=GREY)],
        "frame reads 'radiance' as a vec4f for each pixel, and pass 'a' writes it as a f32",
    ),
    ([step("a", "", "a")], "frame reads 'radiance', which no pass writes"),
]


@pytest.mark.parametrize(("steps", "words"), REFUSED, ids=range(len(REFUSED)))
def test_what_is_refused_names_both(steps, words):
    with pytest.raises(StageError, match=words):
        planned(steps, WANTED)


def test_rings_are_refused():
    with pytest.raises(StageError, match="wait for each other: 'a' for y, 'b' for x"):
        in_order([step("a", "y", "x"), step("b", "x", "y")])


@given(st.permutations(range(6)), st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=8))
def test_readers_come_behind_owners_and_others_stay(order, pairs):
    reads = {n: " ".join(f"n{a}" for a, b in pairs if b == n and a < b) for n in range(6)}
    steps = [step(str(n), reads[n], f"n{n}") for n in order]
    ordered = in_order(steps)
    places = {one.name: place for place, one in enumerate(ordered)}
    assert all(places[name[1:]] < places[one.name] for one in ordered for name in one.reads)
    if not any(reads.values()):
        assert ordered == steps
