"""Which button, finger and key makes which gesture: the one table of the page, of notebooks and of windows.

Each entry is a gesture to be sent, and what makes it. Of ``pointer``: ``left``, ``middle``, ``right``, ``wheel``, ``double``
(a double click or tap), and of fingers ``touch`` (one, as a left button, where nothing else is said) and ``pinch``, ``two``
and ``twist`` of two. Of ``key``: its name, as browsers call it. ``held`` keys repeat while they are down, and their amounts are
those of a second; ``fast`` is how much faster Shift makes them. ``turning`` restricts an entry to one way of turning, and
goes before one that is not restricted. A ``command`` is nothing that is sent: hosts know it.
"""

from __future__ import annotations

from typing import Any

Binding = dict[str, Any]

TURN, MOVE, ZOOM, SPEED, FAST = 0.3, 0.5, 0.5, 1.0, 4.0

BINDINGS: tuple[Binding, ...] = (
    {"pointer": "left", "kind": "orbit", "help": "turn; look round while flying"},
    {"pointer": "left", "modifier": "Shift", "kind": "pan", "help": "move sideways"},
    {"pointer": "left", "modifier": "Control", "kind": "window", "help": "window and level: wider to the right, higher up"},
    {"pointer": "left", "modifier": "Alt", "kind": "roll", "help": "roll"},
    {"pointer": "middle", "kind": "pan", "help": "move sideways"},
    {"pointer": "right", "kind": "dolly", "help": "nearer and farther"},
    {"pointer": "right", "modifier": "Shift", "kind": "roll", "help": "roll"},
    {"pointer": "wheel", "kind": "dolly", "help": "nearer and farther, towards the pointer"},
    {"pointer": "wheel", "modifier": "Shift", "kind": "fov", "help": "angle of view"},
    {"pointer": "double", "kind": "aim", "help": "turn about what is under the pointer"},
    {"pointer": "pinch", "kind": "dolly", "help": "nearer and farther"},
    {"pointer": "two", "kind": "pan", "help": "move sideways"},
    {"pointer": "twist", "kind": "roll", "help": "roll"},
    # While flying, keys go before those that turn.
    {"key": "w", "turning": "fly", "kind": "fly", "dz": SPEED, "held": True, "fast": FAST, "help": "forward and back"},
    {"key": "s", "turning": "fly", "kind": "fly", "dz": -SPEED, "held": True, "fast": FAST, "help": "forward and back"},
    {"key": "a", "turning": "fly", "kind": "fly", "dx": -SPEED, "held": True, "fast": FAST, "help": "sideways"},
    {"key": "d", "turning": "fly", "kind": "fly", "dx": SPEED, "held": True, "fast": FAST, "help": "sideways"},
    {"key": "e", "turning": "fly", "kind": "fly", "dy": -SPEED, "held": True, "fast": FAST, "help": "up and down"},
    {"key": "q", "turning": "fly", "kind": "fly", "dy": SPEED, "held": True, "fast": FAST, "help": "up and down"},
    {"key": "ArrowUp", "turning": "fly", "kind": "fly", "dz": SPEED, "held": True, "fast": FAST, "help": "forward and back"},
    {"key": "ArrowDown", "turning": "fly", "kind": "fly", "dz": -SPEED, "held": True, "fast": FAST, "help": "forward and back"},
    {"key": "ArrowLeft", "turning": "fly", "kind": "look", "dx": TURN, "held": True, "help": "look round"},
    {"key": "ArrowRight", "turning": "fly", "kind": "look", "dx": -TURN, "held": True, "help": "look round"},
    {"key": "ArrowLeft", "kind": "orbit", "dx": -TURN, "held": True, "help": "turn"},
    {"key": "ArrowRight", "kind": "orbit", "dx": TURN, "held": True, "help": "turn"},
    {"key": "ArrowUp", "kind": "orbit", "dy": -TURN, "held": True, "help": "turn"},
    {"key": "ArrowDown", "kind": "orbit", "dy": TURN, "held": True, "help": "turn"},
    {"key": "ArrowLeft", "modifier": "Shift", "kind": "pan", "dx": -MOVE, "held": True, "help": "move sideways"},
    {"key": "ArrowRight", "modifier": "Shift", "kind": "pan", "dx": MOVE, "held": True, "help": "move sideways"},
    {"key": "ArrowUp", "modifier": "Shift", "kind": "pan", "dy": -MOVE, "held": True, "help": "move sideways"},
    {"key": "ArrowDown", "modifier": "Shift", "kind": "pan", "dy": MOVE, "held": True, "help": "move sideways"},
    {"key": "+", "kind": "dolly", "dy": -ZOOM, "held": True, "help": "nearer and farther"},
    {"key": "-", "kind": "dolly", "dy": ZOOM, "held": True, "help": "nearer and farther"},
    {"key": "[", "kind": "roll", "dx": -TURN, "held": True, "help": "roll"},
    {"key": "]", "kind": "roll", "dx": TURN, "held": True, "help": "roll"},
    {"key": ",", "kind": "fov", "dy": -ZOOM, "held": True, "help": "angle of view"},
    {"key": ".", "kind": "fov", "dy": ZOOM, "held": True, "help": "angle of view"},
    {"key": "0", "kind": "fit", "help": "show all of it"},
    {"key": "Home", "kind": "reset", "help": "back to the first view"},
    {"key": "1", "kind": "view", "name": "front", "help": "views from front, back, left, right, top, bottom, corner"},
    {"key": "2", "kind": "view", "name": "back", "help": "views from front, back, left, right, top, bottom, corner"},
    {"key": "3", "kind": "view", "name": "left", "help": "views from front, back, left, right, top, bottom, corner"},
    {"key": "4", "kind": "view", "name": "right", "help": "views from front, back, left, right, top, bottom, corner"},
    {"key": "5", "kind": "view", "name": "top", "help": "views from front, back, left, right, top, bottom, corner"},
    {"key": "6", "kind": "view", "name": "bottom", "help": "views from front, back, left, right, top, bottom, corner"},
    {"key": "7", "kind": "view", "name": "iso", "help": "views from front, back, left, right, top, bottom, corner"},
    {"key": "o", "kind": "orthographic", "help": "parallel rays, and back"},
    {"key": "t", "kind": "turning", "name": "trackball", "help": "turn as a trackball, and back"},
    {"key": "f", "kind": "turning", "name": "fly", "help": "fly, and back"},
    {"key": "b", "kind": "bookmark", "help": "keep this view as a bookmark"},
    {"key": "PageDown", "kind": "recall", "dx": 1.0, "help": "next and previous bookmark"},
    {"key": "PageUp", "kind": "recall", "dx": -1.0, "help": "next and previous bookmark"},
    {"key": "i", "command": "status", "help": "size and frames a second, shown or not"},
    {"key": "p", "command": "panels", "help": "panels, shown or not"},
    {"key": "a", "command": "widget", "help": "a widget of the joint function around what lies under the pointer"},
    {"key": "k", "command": "peak", "help": "a peak of the transfer function at the value under the pointer"},
    {"key": "?", "command": "help", "help": "this list"},
    {"key": "z", "modifier": "Control", "command": "undo", "help": "undo"},
    {"key": "y", "modifier": "Control", "command": "redo", "help": "redo"},
)


def bound(source: str, name: str, modifiers: frozenset[str], turning: str) -> Binding | None:
    """Return the entry that a button, finger or key makes; the most particular where several do.

    Parameters
    ----------
    source
        ``"pointer"`` or ``"key"``.
    name
        Which of them.
    modifiers
        Those that are held: ``Shift``, ``Control``, ``Alt``; ``Meta`` is as good as ``Control``.
    turning
        How the view is turned.
    """
    held = modifiers | ({"Control"} if "Meta" in modifiers else set())

    def fits(entry: Binding) -> bool:
        if entry.get(source) != name or entry.get("turning", turning) != turning:
            return False
        return "modifier" not in entry or entry["modifier"] in held

    fitting = [entry for entry in BINDINGS if fits(entry)]
    return max(fitting, key=lambda entry: ("modifier" in entry) + ("turning" in entry), default=None)
