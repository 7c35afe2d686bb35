"""Renderers: a device with its caches, kept on a thread of its own."""

from __future__ import annotations

import atexit
import threading
import weakref
from collections.abc import Callable, Hashable, Iterable, Iterator
from concurrent.futures import CancelledError, Future
from typing import Any

from ..gpu.device import Device, open_device
from ..gpu.failure import device_failures
from ..gpu.textures import Progress
from ..gpu.thread import Job, RenderThread, T
from ..scene import Scene, check_scene
from ..shader.program import Program
from ..stage import Stage, make_stage
from ..stages.passes import checked_passes
from ..transfer.given import check_size, number, whole
from .budget import draw_in_time
from .frame import Request, draw, explain, relight
from .image import Image
from .refining import Refinement, silent
from .tolerance import draw_within
from .warming import scenes_near


class _Held:
    """The device of a renderer, used on the render thread alone."""

    def __init__(self) -> None:
        self.device: Device | None = None

    def drop(self) -> None:
        """Release the device, if there is one."""
        device, self.device = self.device, None
        if device is not None:
            device.close()

    def tidy(self) -> None:
        """Give up what belonged to volumes, labels and tables that are gone."""
        if self.device is not None:
            self.device.kept.forget_released()


class Renderer:
    """Draws scenes; keeps device, textures, tables and programs from one frame to the next.

    Parameters
    ----------
    device
        Number, kind or part of the name of an adapter; None takes the best (``AIRLIGHT_DEVICE`` names another).
    keep_bytes
        Most bytes that textures, buffers and programs may take on the device beside what a frame itself uses; what was used
        least recently goes first. None: ``AIRLIGHT_KEEP`` (e.g. 4G), else a quarter of the system's memory, on a discrete
        adapter at most what its largest buffer may take.

    Raises
    ------
    ValueRangeError
        When ``keep_bytes`` is no whole number, or negative.
    DeviceError
        At the first frame, when no adapter answers.

    Examples
    --------
    >>> with Renderer() as renderer:                                  # doctest: +SKIP
    ...     frames = [renderer.render(scene, (640, 480)) for scene in scenes]
    """

    def __init__(self, device: str | int | None = None, *, keep_bytes: int | None = None) -> None:
        self._wanted = None if device is None else str(device)
        self._keep_bytes = None if keep_bytes is None else whole(keep_bytes, "keep_bytes", 0)
        self._held = _Held()
        self._refined: dict[Hashable, Refinement] = {}
        self._lock = threading.Lock()  # of what is refined: a frame of a view and the end of its iteration are one
        self._thread = RenderThread(idle=self._held.tidy)
        # Whoever forgets to close a renderer does not keep its thread and device for ever.
        weakref.finalize(self, self._thread.close, self._held.drop, wait=False).atexit = False

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Release the device and all that is on it. Idempotent."""
        with self._lock:
            self._refined.clear()
        self._thread.close(self._held.drop)

    def warm_up(self, scene: Scene | None = None, *, driver: str | Stage = "march") -> None:
        """Open the device in the background; returns at once.

        With a scene, draw a pixel of it, and of those that edits of its transfer functions make of it: nobody who drags a
        control point will wait for a compiler then.
        """
        self._thread.submit(lambda job: self._open())
        for near in () if scene is None else scenes_near(scene):
            self.submit(near, (1, 1), driver=driver)

    def render(
        self,
        scene: Scene,
        size: tuple[int, int] = (512, 512),
        *,
        driver: str | Stage = "march",
        step: float = 1.0,
        skip: str = "auto",
        tolerance: float | None = None,
        budget_ms: float | None = None,
        keep_hits: bool = False,
        passes: Iterable[str | Stage] = (),
        progress: Progress | None = None,
    ) -> Image:
        """Draw a scene and wait for it; see ``airlight.render``."""
        options: dict[str, Any] = {"driver": driver, "step": step, "skip": skip, "tolerance": tolerance, "budget_ms": budget_ms}
        return self.submit(scene, size, **options, keep_hits=keep_hits, passes=passes, progress=progress).result()

    def refine(
        self,
        scene: Scene,
        size: tuple[int, int] = (512, 512),
        *,
        driver: str | Stage = "march",
        skip: str = "auto",
        tolerance: float = 1 / 255,
        keep_hits: bool = False,
        passes: Iterable[str | Stage] = (),
        progress: Progress | None = None,
        view: Hashable = None,
        coarse: bool = True,
    ) -> Iterator[Image]:
        """Draw a scene coarsely at once, then better and better, until all pixels are within a tolerance.

        Parameters
        ----------
        scene, size, driver, skip, tolerance, keep_hits, passes, progress
            As for ``airlight.render``.
        view
            What the images are for. A new frame of the same view, or ``close_view`` from another thread, ends the iteration
            between two tiles, which take about 25 ms each; where the same scene is refined again it goes on from its last
            image, another begins anew.
        coarse
            Begin with small pictures and great steps; without, for who shows such a picture already, the first image is one
            whose error is looked for.

        Yields
        ------
        Image
            ``stats["refined"]`` tells scale and step, ``stats["tolerance"]`` how far errors are known.

        Examples
        --------
        >>> with Renderer() as renderer:                              # doctest: +SKIP
        ...     for image in renderer.refine(scene, (512, 512)):
        ...         show(image)
        """
        request = _request(scene, size, driver, 1.0, skip, keep_hits, number(tolerance, "tolerance"), passes=passes)
        return self._images((scene, request, coarse), progress, view)

    def _images(self, what: tuple[Scene, Request, bool], progress: Progress | None, view: Hashable) -> Iterator[Image]:
        """Images of work that may have begun; each is a job of its own, so that other views are drawn in between."""
        own, reader = object() if view is None else view, object()
        with self._lock:
            work = self._refined.get(own)
            if work is None or work.what != what:
                work = self._refined[own] = Refinement(what)
            work.reader = reader

        def next_image(job: Job[Image | None]) -> Image | None:
            return self._guarded(job, lambda device: work.next(device, job.check, progress or silent))

        try:
            if work.last is not None:
                yield work.last
            while True:
                with self._lock:
                    if self._refined.get(own) is not work or work.reader is not reader:
                        return
                    posted = [self._thread.submit(next_image, own)]
                image = posted.pop().result()  # kept by nobody here: its error leads back to this frame
                if image is None:
                    return
                yield image
        except CancelledError:
            return
        finally:
            if view is None:
                self._refined.pop(own, None)  # without the lock: whoever collects garbage may hold one

    def relight(
        self, image: Image, scene: Scene, *, passes: Iterable[str | Stage] = (), progress: Progress | None = None
    ) -> Image:
        """Light the surfaces of an image again, without a march; see ``airlight.relight``."""

        own = checked_passes(passes)

        def work(job: Job[Image]) -> Image:
            return self._guarded(job, lambda device: relight(device, image, scene, job.check, progress or silent, own))

        return self._thread.submit(work).result()

    def submit(
        self,
        scene: Scene,
        size: tuple[int, int] = (512, 512),
        *,
        driver: str | Stage = "march",
        step: float = 1.0,
        skip: str = "auto",
        tolerance: float | None = None,
        budget_ms: float | None = None,
        keep_hits: bool = False,
        passes: Iterable[str | Stage] = (),
        progress: Progress | None = None,
        view: Hashable = None,
    ) -> Future[Image]:
        """Post a frame; of one ``view`` only the newest frame is drawn, the futures of older ones are cancelled."""
        request = _request(scene, size, driver, step, skip, keep_hits, tolerance, budget_ms, passes)
        way = draw if tolerance is None else draw_within
        way = draw_in_time if budget_ms is not None else way
        with self._lock:
            self._refined.pop(view, None)
            return self._thread.submit(
                lambda job: self._guarded(job, lambda device: way(device, scene, request, job.check, progress or silent)), view
            )

    @property
    def kept_bytes(self) -> int:
        """Bytes that the device keeps for further frames, once it has drawn all that was posted."""

        def work(job: Job[int]) -> int:
            self._held.tidy()
            return 0 if self._held.device is None else self._held.device.kept.bytes

        return self._thread.submit(work).result()

    def close_view(self, view: Hashable) -> None:
        """Give up the frames of a view; others go on."""
        with self._lock:
            self._refined.pop(view, None)
            self._thread.close_view(view)

    def explain(self, scene: Scene, size: tuple[int, int] = (512, 512), driver: str | Stage = "march") -> Program:
        """Return the program that would draw a scene."""
        request = _request(scene, size, driver)

        def work(job: Job[Program]) -> Program:
            return self._guarded(job, lambda device: explain(device, scene, request))

        return self._thread.submit(work).result()

    # -- on the render thread

    @property
    def _device(self) -> Device | None:
        return self._held.device

    def _open(self) -> Device:
        if self._held.device is None:
            self._held.device = open_device(self._wanted, self._keep_bytes)
            self._held.device.kept.owner_released = self._thread.wake
        return self._held.device

    def _guarded(self, job: Job[T], work: Callable[[Device], T]) -> T:
        """Do work on the device; whatever breaks the device leaves room for a new one."""
        device = self._open()
        with device_failures(device.info, self._held.drop):
            return work(device)


def _request(
    scene: Scene,
    size: tuple[int, int],
    driver: str | Stage,
    step: float = 1.0,
    skip: str = "auto",
    keep_hits: bool = False,
    tolerance: float | None = None,
    budget_ms: float | None = None,
    passes: Iterable[str | Stage] = (),
) -> Request:
    """What is asked of a frame of a scene, checked."""
    check_scene(scene)
    check_size(size)
    tolerance = None if tolerance is None else number(tolerance, "tolerance")
    budget_ms = None if budget_ms is None else number(budget_ms, "budget_ms")
    chosen = make_stage("driver", driver)
    size_px, own = (int(size[0]), int(size[1])), checked_passes(passes)
    return Request(size_px, chosen, number(step, "step"), skip, keep_hits, tolerance, budget_ms, passes=own)


_shared: dict[str | None, Renderer] = {}
_lock = threading.Lock()


def shared(device: str | int | None = None) -> Renderer:
    """Renderer that the functions of the package share, one for each choice of device."""
    key = None if device is None else str(device)
    with _lock:
        if key not in _shared:
            _shared[key] = Renderer(device)
        return _shared[key]


def close_shared() -> None:
    """Release the shared renderers; the next call opens new ones."""
    with _lock:
        for renderer in _shared.values():
            renderer.close()
        _shared.clear()


atexit.register(close_shared)
