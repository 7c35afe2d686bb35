"""The viewer over its own server: how soon the first picture comes, and how smooth dragging and editing are.

A scripted client starts ``airlight view`` as a process of its own and talks to it through a WebSocket, as pages do; pictures
are acknowledged as soon as they are there, so that what a browser takes to show them is not in these numbers. The CT head with
its default first picture at 512x512. ``--soak MINUTES`` looks at it with four clients instead, each with a view of its own:
they turn, edit and rest by a script; one is killed and another is cut off, both come back to their views, and a third sleeps
for a while.
"""

from __future__ import annotations

import contextlib
import io
import math
import re
import secrets
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import numpy as np
from cold_start import COMMAND, input_file
from common import arguments, parsed, psnr, table, write_json
from PIL import Image as Pillow
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from airlight.viewer.serving.framing import packed, unpacked

FIRST_S = 2.5
FRAMES_PER_S = 20.0
LATENCY_MS = 100.0
PSNR_DB = 28.0
LEAST_SCALE, MOST_STEP = 0.5, 2.0
REST_S = 1.5
EDIT_MS = 120.0
SHARES = (0.1, 0.25, 0.5, 0.75, 1.0)
GROWTH_PERCENT = 5.0
LEAST_SHARE = 0.5
"""Of the pictures of the client that got most of them, each other gets at least so many."""

POINTER_S = 1 / 60
POINT = ["scene", "layers", 0, "transfer", "points", -2]
WAIT_S = 60.0


class Server:
    """``airlight view`` as a process."""

    def __init__(self, volume: Path) -> None:
        self.started = time.perf_counter()
        command = [sys.executable, "-c", COMMAND, "view", str(volume), "--no-browser"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        address = next(found for line in self.process.stdout if (found := re.search(r"http://\S+", line)))[0]
        parts = urlsplit(address)
        self.origin, self.port = f"http://{parts.netloc}", parts.port
        self.token = parse_qs(parts.query)["token"][0]

    def socket(self, session: str = "") -> Any:
        """Open a socket to a new view, or to one that was left."""
        cookie = {"Cookie": f"airlight-{self.port}={self.token}"}
        address = f"ws://127.0.0.1:{self.port}/socket" + (f"?session={session}" if session else "")
        return connect(address, origin=self.origin, additional_headers=cookie, max_size=None, compression=None)

    def memory_bytes(self) -> int | None:
        """What the process holds in memory; None where the system does not tell."""
        try:
            text = Path(f"/proc/{self.process.pid}/status").read_text()
        except OSError:
            return None
        return 1024 * int(re.search(r"VmRSS:\s+(\d+)", text)[1])  # type: ignore[index]

    def stop(self) -> None:
        self.process.terminate()
        self.process.communicate(timeout=20)


class Client:
    """One who looks: keeps what it is told, and acknowledges pictures."""

    def __init__(self, server: Server, size_px: int, session: str = "") -> None:
        self.server, self.size_px, self.session = server, size_px, session
        self.frames: list[tuple[float, dict[str, Any]]] = []
        self.last_data: dict[bool, bytes] = {}
        self.states: list[dict[str, Any]] = []
        self.errors: list[str] = []
        self.sent = 0
        self.awake = threading.Event()
        self.awake.set()
        self._open()

    def _open(self) -> None:
        self.leaving = False
        self.base: int | None = None
        self._held = contextlib.ExitStack()
        self.link = self._held.enter_context(self.server.socket(self.session))
        self._thread = threading.Thread(target=self._listen, args=(self.link,), daemon=True)
        self._thread.start()
        self.send({"type": "hello", "size_px": [self.size_px, self.size_px], "ratio": 1})

    def send(self, message: dict[str, Any]) -> None:
        self.link.send(packed(message, []))

    def _listen(self, link: Any) -> None:
        try:
            for data in link:
                self.awake.wait()
                self._take(*unpacked(data))
        except (ConnectionClosed, OSError) as error:
            if not self.leaving:
                self.errors.append(f"the connection ended ({error})")

    def _take(self, message: dict[str, Any], buffers: list[bytes]) -> None:
        kind = message["type"]
        if kind == "frame":
            if self.base is None:
                self.base = message["inputs"] - self.sent
            self.last_data[message["final"]] = bytes(buffers[0])
            self.frames.append((time.perf_counter(), message))
            self.send({"type": "ack", "frame": message["frame"]})
        elif kind == "welcome":
            self.session = message["session"]
        elif kind == "state":
            self.states.append(message)
        elif kind == "error":
            self.errors.append(str(message))

    # -- input

    def turn(self, dx: float, dy: float = 0.0) -> float:
        """Turn; returns when."""
        self.sent += 1
        start = time.perf_counter()
        self.send({"type": "gesture", "kind": "orbit", "dx": dx, "dy": dy})
        return start

    def edit(self, path: list[Any], value: Any) -> float:
        """Change the state; returns when."""
        self.sent += 1
        start = time.perf_counter()
        self.send({"type": "edit", "ops": [{"op": "set", "path": path, "value": value}], "merge": "benchmark"})
        return start

    def shown(self, inputs: int, where: Callable[[dict[str, Any]], Any] = lambda frame: True) -> tuple[float, dict[str, Any]]:
        """Wait for the first picture of a kind that shows so many inputs."""
        end, seen = time.perf_counter() + WAIT_S, 0
        while time.perf_counter() < end:
            new = self.frames[seen:]
            for when, frame in new:
                if self.base is not None and frame["inputs"] - self.base >= inputs and where(frame):
                    return when, frame
            seen += len(new)
            time.sleep(0.001)
        raise SystemExit(f"a picture did not come: {self.errors[-3:]}")

    def latencies_ms(self, sent: dict[int, float]) -> list[float]:
        """Milliseconds from inputs, by number, to the first picture that shows each."""
        assert self.base is not None
        found, waiting = [], dict(sent)
        for when, frame in list(self.frames):
            shown = [number for number in waiting if number <= frame["inputs"] - self.base]
            found += [1e3 * (when - waiting.pop(number)) for number in shown]
        return found

    # -- coming and going

    def leave(self, abruptly: bool) -> None:
        """Close the connection, or drop it as a killed program does."""
        self.leaving = True
        if abruptly:
            with contextlib.suppress(OSError):
                self.link.socket.shutdown(2)
            self.link.socket.close()
        with contextlib.suppress(OSError, ConnectionClosed):
            self._held.close()
        self._thread.join(WAIT_S)

    def come_back(self) -> None:
        self.sent = 0
        self._open()


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a bar is missed."""
    parser = arguments(__doc__, "viewer", repeats=5, size=512)
    parser.add_argument("--seconds", type=float, default=5.0, help="of each drag (default: %(default)s)")
    parser.add_argument("--soak", type=float, default=0.0, metavar="MINUTES", help="look at it with four clients for so long")
    options = parsed(parser, argv, repeats=1, size=64, seconds=0.5)
    with tempfile.TemporaryDirectory() as folder:
        volume = input_file(Path(folder), options.quick)
        bars: list[dict[str, Any]] = []
        if not options.soak:
            bars = measured(volume, options)
        if options.soak or options.quick:
            bars += soaked(volume, options, options.soak or 0.03)
    print(table(bars))
    passes = all(bar["passes"] != "FAIL" for bar in bars)
    print(f"\n{'PASS' if passes else 'FAIL'}")
    about = {"quick": options.quick, "size": options.size, "volume": volume.name, "soak_minutes": options.soak}
    write_json(options.out, about | {"bars": bars, "passes": passes})
    return 0 if passes or options.quick else 1


def bar(what: str, found: float | None, least: float | None = None, most: float | None = None) -> dict[str, Any]:
    """A number with what it must reach."""
    if found is None:
        return {"what": what, "found": "not told", "bar": "", "passes": ""}
    reached = (least is None or found >= least) and (most is None or found <= most)
    text = f">= {least:g}" if least is not None else f"<= {most:g}" if most is not None else ""
    return {
        "what": what,
        "found": round(float(found), 2),
        "bar": text,
        "passes": ("PASS" if reached else "FAIL") if text else "",
    }


@contextlib.contextmanager
def served(volume: Path) -> Iterator[Server]:
    server = Server(volume)
    try:
        yield server
    finally:
        server.stop()


# -- one client


def measured(volume: Path, options: Any) -> list[dict[str, Any]]:
    """First picture, dragging, rest and edits."""
    firsts = []
    for _ in range(options.repeats - 1):
        with served(volume) as server:
            client = Client(server, options.size)
            firsts.append(client.shown(0)[0] - server.started)
            client.leave(abruptly=False)
    with served(volume) as server:
        client = Client(server, options.size)
        firsts.append(client.shown(0)[0] - server.started)
        client.shown(
            0, lambda frame: frame["refined"] and (frame["step"] < 0.2 or frame["tolerance_reached"])
        )  # all is compiled
        found = [dragged(client, options.seconds, turn) for turn in range(options.repeats)]
        edits = edited(client, 5 if options.quick else 60)
        refined_at, _ = client.shown(client.sent, lambda frame: frame["refined"])
        errors = len(client.errors)
        client.leave(abruptly=False)
    latencies = np.concatenate([drag["latencies"] for drag in found])
    moving = [frame for drag in found for frame in drag["frames"]]
    return [
        bar("process start to first picture sent, median [s]", float(np.median(firsts)), most=FIRST_S),
        bar("dragging: pictures a second, least of all drags", min(drag["rate"] for drag in found), least=FRAMES_PER_S),
        bar("dragging: pointer to picture, p50 [ms]", float(np.percentile(latencies, 50))),
        bar("dragging: pointer to picture, p95 [ms]", float(np.percentile(latencies, 95)), most=LATENCY_MS),
        bar("dragging: least scale", min(frame["scale"] for frame in moving), least=LEAST_SCALE),
        bar("dragging: greatest step [voxels]", max(frame["step"] for frame in moving), most=MOST_STEP),
        bar("dragging: PSNR of a moving picture, least [dB]", min(drag["psnr_db"] for drag in found), least=PSNR_DB),
        bar("dragging: to draw, median [ms]", float(np.median([frame["ms"]["draw"] for frame in moving]))),
        bar("dragging: to encode, median [ms]", float(np.median([frame["ms"]["encode"] for frame in moving]))),
        bar("full picture after the last input, greatest [s]", max(drag["rest_s"] for drag in found), most=REST_S),
        bar("edit to picture, p50 [ms]", float(np.percentile(edits, 50))),
        bar("edit to picture, p95 [ms]", float(np.percentile(edits, 95)), most=EDIT_MS),
        bar("refined picture after the last full one [s]", refined_at - found[-1]["full_at"]),
        bar("errors", errors, most=0),
    ]


def dragged(client: Client, seconds: float, turn: int) -> dict[str, Any]:
    """Drag for a while, then rest: rate, latencies, and how far the last moving picture is from the full one."""
    sent, first, start = {}, len(client.frames), time.perf_counter()
    while (now := time.perf_counter() - start) < seconds:
        # At least one step to the next, so that there is always something to draw.
        when = client.turn(0.004 * (1 if turn % 2 else -1), 0.002 * math.cos(now))
        sent[client.sent] = when
        time.sleep(POINTER_S)
    last = max(sent.values())
    client.shown(client.sent)
    full_at, _ = client.shown(client.sent, lambda frame: frame["final"])
    moving = [(at, frame) for at, frame in client.frames[first:] if not frame["final"]]
    in_time = [at for at, _ in moving if at <= start + seconds]
    quick, full = (pixels(client.last_data[final], client.size_px) for final in (False, True))
    return {
        "rate": len(in_time) / seconds,
        "latencies": client.latencies_ms(sent),
        "frames": [frame for _, frame in moving],
        "psnr_db": psnr(float(np.sqrt(((quick - full) ** 2).mean()))),
        "rest_s": full_at - last,
        "full_at": full_at,
    }


def pixels(data: bytes, size_px: int) -> np.ndarray[Any, Any]:
    """Pixels of a picture in [0, 1], enlarged as browsers do."""
    picture = Pillow.open(io.BytesIO(data)).convert("RGB").resize((size_px, size_px), Pillow.Resampling.BILINEAR)
    return np.asarray(picture, dtype=np.float64) / 255


def edited(client: Client, count: int) -> list[float]:
    """Drag a control point of the transfer function; milliseconds until each of its places is seen."""
    points = client.states[-1]["document"]["scene"]["layers"][0]["transfer"]["points"]
    number = len(points) - 2
    value, colour, extinction = points[number]
    low, high = points[number - 1][0], points[number + 1][0]
    spent = []
    for step in range(count):
        place = value + 0.3 * ((low if step % 2 else high) - value) * (1 + step) / count
        path = [*POINT[:-1], number]
        start = client.edit(path, [place, colour, extinction * (1 + 0.5 * step / count)])
        spent.append(1e3 * (client.shown(client.sent)[0] - start))
        time.sleep(0.02)
    return spent


# -- four clients


def soaked(volume: Path, options: Any, minutes: float) -> list[dict[str, Any]]:
    """Four clients for so many minutes: memory, errors, who gets how many pictures, and what those find who come back."""
    with served(volume) as server:
        clients = [Client(server, options.size) for _ in range(4)]
        for client in clients:
            client.shown(0, lambda frame: frame["final"])
        seconds, start, kept = 60 * minutes, time.perf_counter(), []
        memory: list[tuple[float, int | None]] = []
        threads = [threading.Thread(target=played, args=(clients[0], 0, start + seconds))]
        threads += [
            threading.Thread(target=gone, args=(client, n, start, seconds, kept)) for n, client in enumerate(clients) if n
        ]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            memory.append((time.perf_counter() - start, server.memory_bytes()))
            time.sleep(min(1.0, seconds / 10))
        counts = [len(client.frames) for client in clients]
        errors = [error for client in clients for error in client.errors]
        for client in clients:
            client.leave(abruptly=False)
    for error in errors[:5]:
        print(error, file=sys.stderr)
    return [
        bar("four clients: growth of memory [%]", growth(memory, seconds), most=GROWTH_PERCENT),
        *(
            bar(f"four clients: memory after {share:.0%} of the time [MiB]", held_at(memory, share * seconds))
            for share in SHARES
        ),
        bar("four clients: errors", len(errors), most=0),
        bar("four clients: fewest pictures of one", min(counts), least=LEAST_SHARE * max(counts)),
        bar("four clients: most pictures of one", max(counts)),
        bar("four clients: came back to their state, of 3", sum(kept), least=3),
    ]


def held_at(memory: list[tuple[float, int | None]], at_s: float) -> float | None:
    """MiB that were held at a time."""
    nearest = min(memory, key=lambda one: abs(one[0] - at_s))[1]
    return None if nearest is None else nearest / 2**20


def growth(memory: list[tuple[float, int | None]], seconds: float) -> float | None:
    """Percent by which memory is greater in the last tenth than in the second: the first has filled the caches."""
    early = [held for at, held in memory if 0.1 * seconds <= at <= 0.2 * seconds and held is not None]
    late = [held for at, held in memory if at >= 0.9 * seconds and held is not None]
    return 100 * (float(np.median(late)) / float(np.median(early)) - 1) if early and late else None


def played(client: Client, seed: int, end: float) -> None:
    """Turn, edit, change the size and rest, by a script, until a time."""
    rng = np.random.default_rng(seed)
    while time.perf_counter() < end:
        for _ in range(int(rng.integers(30, 120))):
            if time.perf_counter() >= end:
                return
            client.turn(*(float(by) for by in rng.normal(0, 0.01, 2)))
            time.sleep(POINTER_S)
        for _ in range(int(rng.integers(2, 10))):
            client.edit(["scene", "layers", 0, "density"], float(rng.uniform(0.5, 2.0)))
            time.sleep(0.1)
        size_px = int(client.size_px * rng.choice([1.0, 0.75]))
        client.sent += 1
        client.send({"type": "size", "size_px": [size_px, size_px]})
        time.sleep(min(float(rng.uniform(0.2, 3.0)), max(end - time.perf_counter(), 0.0)))


def gone(client: Client, number: int, start: float, seconds: float, kept: list[bool]) -> None:
    """As ``played``, but for a while in the middle: 1 is killed, 2 is cut off, 3 sleeps."""
    played(client, number, start + 0.4 * seconds)
    mark = 1.0 + secrets.randbelow(1000) / 1000
    client.edit(["scene", "layers", 0, "density"], mark)
    client.shown(client.sent)
    pause_s = min(0.1 * seconds, 15.0)
    if number == 3:
        client.awake.clear()
        time.sleep(pause_s)
        client.awake.set()
    else:
        client.leave(abruptly=True)
        time.sleep(pause_s if number == 1 else 0.5)
        client.states.clear()
        client.come_back()
    client.turn(0.01)
    client.shown(client.sent, lambda frame: frame["final"])
    kept.append(client.states[-1]["document"]["scene"]["layers"][0]["density"] == mark)
    played(client, number, start + seconds)


if __name__ == "__main__":
    sys.exit(main())
