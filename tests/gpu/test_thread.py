"""The render thread: order, fairness, cancelling, closing."""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError

import pytest

from airlight.errors import DeviceError
from airlight.gpu.thread import Cancelled, RenderThread


@pytest.fixture
def thread():
    made = RenderThread()
    yield made
    made.close()


def hold(thread) -> threading.Event:
    """Keep the thread busy until the event is set."""
    release, begun = threading.Event(), threading.Event()

    def work(job):
        begun.set()
        release.wait(10)

    thread.submit(work)
    begun.wait(10)
    return release


def test_all_work_runs_on_one_thread_in_order(thread):
    seen = []
    futures = [thread.submit(lambda job, i=i: seen.append((i, threading.current_thread().name))) for i in range(20)]
    for future in futures:
        future.result(10)
    assert [i for i, _ in seen] == list(range(20))
    assert {name for _, name in seen} == {"airlight-render"}


def test_of_a_view_only_the_newest_frame_is_kept(thread):
    release = hold(thread)
    frames = [thread.submit(lambda job, i=i: i, view="a") for i in range(5)]
    release.set()
    assert frames[-1].result(10) == 4
    for old in frames[:-1]:
        with pytest.raises(CancelledError):
            old.result(10)


def test_a_running_frame_is_told_that_a_newer_one_came(thread):
    begun = threading.Event()

    def endless(job):
        begun.set()
        while True:
            job.check()

    old = thread.submit(endless, view="a")
    begun.wait(10)
    assert thread.submit(lambda job: "new", view="a").result(10) == "new"
    with pytest.raises(Cancelled):
        old.result(10)


def test_views_take_turns(thread):
    release = hold(thread)
    seen = []
    futures = [thread.submit(lambda job, i=i: seen.append(i)) for i in range(3)]
    futures += [thread.submit(lambda job, v=v: seen.append(v), view=v) for v in "ab"]
    release.set()
    for future in futures:
        future.result(10)
    assert seen.index("a") < seen.index(2)
    assert seen.index("b") < seen.index(2)


def test_closing_a_view_leaves_the_others(thread):
    release = hold(thread)
    gone, stays = (thread.submit(lambda job: "drawn", view=v) for v in "ab")
    thread.close_view("a")
    release.set()
    assert stays.result(10) == "drawn"
    assert gone.cancelled()


def test_errors_reach_who_waits(thread):
    def broken(job):
        raise ValueError("mine")

    with pytest.raises(ValueError, match="mine"):
        thread.submit(broken).result(10)
    assert thread.submit(lambda job: 1).result(10) == 1


def test_close_runs_the_last_work_and_is_idempotent():
    thread, last = RenderThread(), []
    thread.close(lambda: last.append(threading.current_thread().name))
    thread.close()
    assert last == ["airlight-render"]
    with pytest.raises(DeviceError, match="renderer is closed: make a new one"):
        thread.submit(lambda job: None)
