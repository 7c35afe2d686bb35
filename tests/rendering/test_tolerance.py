"""Pictures of a known error stay within it, pictures that get better do, and pictures in a given time say what was chosen."""

from __future__ import annotations

import threading
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scenes import blobs, cameras, function, lights, rotation

import airlight as al
import airlight.rendering.refining
import airlight.rendering.tolerance
from airlight import reference
from airlight.rendering.budget import LADDER, Cost, _chosen, enlarged, scaled
from airlight.rendering.frame import Request, draw_pixels
from airlight.rendering.tolerance import Known, greatest_around

SIZE = (24, 20)
FINE = 1 / 64
SMOOTH = ("smooth", "peaks", "surfaces", "spline")  # of which half as fine a truth tells as much, in half the time
ROUNDING = 1e-5

PEAKS = al.TransferFunction(
    [(v + d, rgb, t) for v, rgb in ((45, "red"), (70, "lime"), (95, "white")) for d, t in ((-1, 0), (0, 8), (1, 0))]
)
STEPS = al.TransferFunction(
    [(50, "red", 0), (50, "red", 1), (80, "red", 1), (80, "blue", 0), (90, "blue", 0), (91, "white", 4)]
)
GLOW = al.TransferFunction([(40, (0, 0, 0), 0), (70, (0.3, 0.5, 0.1), 0.1), (90, (0, 0, 0), 0)], associated=True)
SHEETS = al.TransferFunction.from_surfaces([al.Surface(45.0, "gold", opacity=0.4), al.Surface(80.0, "red")])
LIT = {"shade": "blinn_phong"}
UNLIT = {"shade": "none"}
CASES = {
    "smooth": (function(), LIT, 0.004),
    "post-classified peaks": (PEAKS, UNLIT | {"transfer": "postclassified"}, 0.01),
    "peaks": (PEAKS, LIT | {"lighting": "sampled"}, 0.02),
    "steps": (STEPS, UNLIT, 0.002),
    "emission": (GLOW, UNLIT, 0.001),
    "surfaces": (SHEETS, LIT, 0.01),
    "first hit": (function(), LIT | {"integrate": al.integrate.FirstHit(iso=60.0)}, 0.01),
    "maximum": (function(), UNLIT | {"integrate": "mip"}, 0.004),
    "mean": (function(), UNLIT | {"integrate": "mean"}, 0.002),
    "nearest": (function(), UNLIT | {"field": "nearest"}, 0.01),
    "spline": (function(), UNLIT | {"field": "bspline"}, 0.001),
}


@cache
def rough() -> al.Volume:
    """A field that bends within each of its cells."""
    rng = np.random.default_rng(3)
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, 2, 3), 0.4) * (1.0, 1.2, 0.9)
    return al.Volume(rng.uniform(20, 110, (11, 10, 9)).astype(np.float32), world_from_index=matrix)


def drawn(tf: al.TransferFunction, look: dict, camera: str = "perspective", **more) -> al.Scene:
    volume = blobs() if tf.surfaces else rough()
    made = al.Look(**look)
    return al.Scene(
        volume, transfer=tf, camera=cameras(volume)[camera], look=made, lights=lights()[:2], background=None, **more
    )


def case(name: str) -> tuple[al.Scene, float]:
    tf, look, tolerance = CASES[name]
    return drawn(tf, look), tolerance


def truth(name: str) -> np.ndarray:
    return reference.converged(case(name)[0], SIZE, step=2 * FINE if name in SMOOTH else FINE).rgba


@pytest.mark.parametrize("name", CASES)
def test_the_error_is_within_the_tolerance(renderer, name):
    scene, tolerance = case(name)
    image = renderer.render(scene, SIZE, tolerance=tolerance)
    told = image.stats["tolerance"]
    errors = np.abs(image.rgba - truth(name)).max(axis=-1)
    assert told["pixels_over"] == 0
    assert errors.max() <= tolerance
    assert told["maximum"] == image.estimate.max() <= tolerance
    assert np.sqrt((errors**2).mean()) <= told["rms"] + ROUNDING
    assert told["rms"] <= told["maximum"]
    assert image.rgba.any()


def test_plain_frames_are_further_off(renderer):
    """So that the test above says something: a step of a voxel would not pass it."""
    scene, tolerance = case("peaks")
    plain = renderer.render(scene, SIZE)
    assert np.abs(plain.rgba - truth("peaks")).max() > 2 * tolerance


def test_only_what_changes_is_drawn_again(renderer):
    told = renderer.render(drawn(PEAKS, LIT), SIZE, tolerance=0.02).stats
    steps = told["tolerance"]["pixels_by_step"]
    counts = list(steps.values())
    assert list(steps) == [0.5**n for n in range(1, len(steps) + 1)]
    assert counts[0] == counts[1] == SIZE[0] * SIZE[1]
    assert counts == sorted(counts, reverse=True)
    assert counts[-1] < counts[2] < counts[0]
    assert told["tolerance"]["stopped"] == "all pixels are within the tolerance"


def test_what_is_met_is_kept(renderer):
    scene, tolerance = case("first hit")
    image = renderer.render(scene, SIZE, tolerance=tolerance, keep_hits=True)
    fine = renderer.render(scene, SIZE, step=0.05, keep_hits=True)
    assert np.mean(image.hits.side != fine.hits.side) < 0.01
    assert np.median(np.abs(image.normal - fine.normal)) < 1e-3
    assert np.nanmax(np.abs(renderer.relight(image, scene).rgba - image.rgba)) < 1e-3


def test_annotations_and_empty_scenes(renderer):
    empty = renderer.render(
        drawn(function(), UNLIT, clips=[al.Clip.sphere(center=(1e3, 0, 0), radius=1.0)]), SIZE, tolerance=0.01
    )
    assert "reason" in empty.stats
    assert not empty.rgba.any()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"tolerance": 1e-7}, "32-bit floats"),
        ({"tolerance": 1.0}, "must lie in"),
        ({"tolerance": float("nan")}, "must lie in"),
        ({"budget_ms": 0}, "positive"),
        ({"budget_ms": float("inf")}, "positive"),
        ({"tolerance": "0.01"}, "must be a number"),
        ({"budget_ms": True}, "must be a number"),
        ({"step": "half"}, "must be a number"),
        ({"tolerance": 0.01, "step": 0.5}, "beside step"),
        ({"tolerance": 0.01, "budget_ms": 10}, "beside budget_ms"),
    ],
)
def test_what_cannot_be_asked(renderer, options, said):
    with pytest.raises(al.ValueRangeError, match=said):
        renderer.render(drawn(function(), UNLIT), SIZE, **options)


def test_what_cannot_be_refined(renderer):
    for what, tolerance in ((drawn(function(), UNLIT), None), (blobs(), 0.01)):
        with pytest.raises(al.AirlightError, match=r"must be a number|pass an airlight.Scene"):
            renderer.refine(what, SIZE, tolerance=tolerance)


def test_rays_that_end_at_the_first_step_are_an_error(renderer, monkeypatch):
    """Nothing is known of their pixels at all."""

    def ended(*asked):
        image, samples = draw_pixels(*asked)
        return image, -samples

    monkeypatch.setattr(airlight.rendering.tolerance, "draw_pixels", ended)
    with pytest.raises(al.LimitError, match="ended rays"):
        renderer.render(drawn(function(), UNLIT), SIZE, tolerance=0.01)


def test_tones_of_the_whole_image(renderer):
    with pytest.raises(al.StageError, match="whole image"):
        renderer.render(drawn(function(), UNLIT | {"tone": "reinhard"}), SIZE, tolerance=0.01)


def test_rays_that_the_device_ends_are_told():
    """Their pixels keep what was there, and are counted."""
    known = Known((8, 1), 0.1)
    samples = np.full((1, 8), 9, np.float32)

    def part(rgb: float) -> al.Image:
        return al.Image(np.full((1, 8, 4), rgb, np.float32), np.zeros((1, 8), np.float32))

    known.take(0.5, part(0.0), samples)
    known.take(0.25, part(0.5), samples + 9)
    known.take(0.125, part(0.7), np.where(np.arange(8) < 3, -1, samples + 18).astype(np.float32))
    assert (known.image(drawn(function(), UNLIT)).rgba[0, :, 0] == np.float32([0.5] * 3 + [0.7] * 5)).all()
    assert known.open[0].tolist() == [False] * 3 + [True] * 5
    known.take(0.0625, part(0.7), samples + 27)
    known.take(0.03125, part(0.7), samples + 36)
    told = known.statistics()["tolerance"]
    assert told["pixels_over"] == 5
    assert "device ended their rays" in told["stopped"]
    assert np.isinf(known.estimate[0, :5]).all()
    assert known.estimate[0, 5:].max() == 0


def test_neighbours_count():
    estimate = np.zeros((7, 9), np.float32)
    estimate[3, 4] = 1
    around = greatest_around(estimate)
    assert around.sum() == 25
    assert (around[1:6, 2:7] == 1).all()


# -- better and better


def test_images_get_better(renderer):
    scene, _ = case("peaks")
    images = list(renderer.refine(scene, SIZE, tolerance=0.02))
    told = [image.stats["refined"] for image in images]
    assert [(t["scale"], t["step"]) for t in told[:4]] == [(0.25, 2.0), (0.5, 2.0), (1.0, 1.0), (1.0, 0.5)]
    assert all(image.size == SIZE for image in images)
    right = truth("peaks")
    errors = [np.abs(image.rgba - right).max() for image in images]
    assert errors[-1] <= 0.02 < errors[2]
    assert np.sqrt(np.mean((images[0].rgba - right) ** 2)) > np.sqrt(np.mean((images[2].rgba - right) ** 2))
    assert np.array_equal(images[-1].rgba, renderer.render(scene, SIZE, tolerance=0.02).rgba)


def test_a_view_goes_on_where_it_was_and_begins_anew_for_another_look(renderer):
    scene = drawn(PEAKS, LIT)
    first = renderer.refine(scene, SIZE, tolerance=0.02, view="one")
    for _ in range(3):
        last = next(first)
    again = next(renderer.refine(scene, SIZE, tolerance=0.02, view="one"))
    assert again is last
    other = next(renderer.refine(replace(scene, lights=lights()[:1]), SIZE, tolerance=0.02, view="one"))
    assert other.stats["refined"]["scale"] == 0.25
    renderer.close_view("one")
    assert next(renderer.refine(scene, SIZE, tolerance=0.02, view="one")).stats["refined"]["scale"] == 0.25
    renderer.close_view("one")


def test_a_new_frame_of_a_view_ends_the_iteration_and_is_drawn(renderer):
    scene = drawn(function(), UNLIT)
    images = renderer.refine(scene, SIZE, tolerance=0.001, view="two")
    next(images)
    newer = renderer.submit(scene, (8, 8), view="two")
    assert list(images) == []
    assert newer.result().size == (8, 8)
    others = renderer.refine(scene, SIZE, tolerance=0.001, view="two")
    next(others)
    newest = renderer.refine(scene, SIZE, tolerance=0.001, view="two")
    assert next(newest).stats["refined"]["scale"] == 0.25
    assert list(others) == []
    assert list(newest)[-1].stats["tolerance"]["pixels_over"] == 0
    renderer.close_view("two")


def test_work_begins_anew_on_another_device(monkeypatch):
    """Where one is lost, between two images, the next is drawn on another."""
    monkeypatch.setattr(airlight.rendering.refining, "better_and_better", lambda device, *_: iter([device, device]))
    work = airlight.rendering.refining.Refinement((None, None))
    assert [work.next(device, lambda: None, lambda *_: None) for device in "aabb"] == list("aabb")


def test_work_that_is_given_up_ends(renderer):
    scene = drawn(PEAKS, LIT)
    images = renderer.refine(scene, (512, 512), tolerance=1e-5, view="given up")
    next(images)
    threading.Timer(0.3, renderer.close_view, ["given up"]).start()
    shown = list(images)
    assert all(image.stats["refined"]["step"] > 1e-3 for image in shown)
    after = renderer.submit(scene, SIZE, view="given up")
    assert after.result().rgba.any()


# -- in a given time


def test_time_picks_scale_and_step():
    cost = Cost(frame_ms=5.0, pixel_ms=1e-4, samples_ms=2e-4)
    request = Request((512, 512), al.driver.March())
    chosen = [_chosen(cost, request, budget) for budget in (1000, 300, 100, 50, 20, 5)]
    assert chosen == sorted(chosen, key=LADDER.index)
    assert chosen[0] == LADDER[0]
    assert chosen[-1] == LADDER[-1]
    for (scale, step), budget in zip(chosen[:-1], (1000, 300, 100, 50, 20), strict=True):
        width, height = scaled((512, 512), scale)
        assert cost.of(width * height, step) <= budget
    assert _chosen(cost, replace(request, keep_hits=True), 5)[0] == 1.0


def test_costs_follow_what_frames_take():
    cost = Cost(1.0, 1e-3, 1e-3)
    for _ in range(20):
        cost.learn(10_000, 1.0, 101.0)
    assert cost.of(10_000, 1.0) == pytest.approx(101.0, rel=0.02)


def test_a_first_frame_that_took_long_is_forgotten():
    cost = Cost(500.0, 1e-3, 1e-3)
    cost.learn(10_000, 1.0, 21.0)
    assert cost.of(10_000, 1.0) < 50


def test_frames_in_time_of_nothing(renderer):
    layer = al.Layer(rough(), transfer=function(), visible=False)
    nothing = al.Scene(layers=[layer], camera=cameras(rough())["perspective"], background=None)
    assert not renderer.render(nothing, SIZE, budget_ms=10).rgba.any()


def test_pictures_of_several_steps_or_enlarged_have_no_disagreement(renderer):
    for options in ({"tolerance": 0.05}, {"budget_ms": 0.001}):
        image = renderer.render(drawn(function(), UNLIT), SIZE, driver=al.driver.March(offsets="interleaved"), **options)
        assert image.stats["size"] == list(image.size)
        assert "disagreement" not in image.stats
        with pytest.raises(al.DataError, match="one step"):
            _ = image.disagreement


def test_frames_in_time_are_told_and_as_large_as_asked(renderer):
    scene = drawn(function(), UNLIT)
    for budget in (0.001, 1e6):
        image = renderer.render(scene, (64, 48), budget_ms=budget)
        told = image.stats["budget"]
        assert image.size == (64, 48)
        assert (told["scale"], told["step"]) == (LADDER[-1] if budget < 1 else LADDER[0])
        assert told["asked_ms"] == budget
        assert told["spent_ms"] > 0
        assert image.rgba.any()


def test_enlarged_images_lie_where_they_did():
    x = np.linspace(0, 1, 16, dtype=np.float32)
    rgba = np.broadcast_to(x[:, None], (12, 16, 4)).copy()
    image = enlarged(al.Image(rgba, np.full((12, 16), np.inf, np.float32)), (64, 48))
    assert image.size == (64, 48)
    places = (np.arange(64) + 0.5) / 4 - 0.5
    assert np.allclose(image.rgba[20, 2:-2, 1], np.interp(places, np.arange(16), x)[2:-2], atol=1e-6)
    assert np.isinf(image.depth).all()
