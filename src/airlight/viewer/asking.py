"""Questions that clients ask of a session: each is a function in a module of ``asked``, found by its name.

A new one is a file: ``asked/histogram.py`` answers ``histogram``, and ``histogram.joint`` where there is a second.
"""

from __future__ import annotations

import inspect
import pkgutil
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import ValueRangeError

if TYPE_CHECKING:
    from .session import Session

Answer = Callable[..., Any]
F = TypeVar("F", bound=Answer)
_ANSWERS: dict[str, Answer] = {}
_SLOW: set[str] = set()


def answers(what: str, slow: bool = False) -> Callable[[F], F]:
    """Decorate the function that answers a question: ``function(session, **arguments)`` returns plain data.

    Or a pair of plain data and a list of bytes, which clients get as buffers; those that came with the question are the
    argument ``buffers``. It runs on the session's worker thread; what is ``slow`` on another, so that no other question waits.
    """

    def kept(function: F) -> F:
        _ANSWERS[what] = function
        (_SLOW.add if slow else _SLOW.discard)(what)
        return function

    return kept


def is_slow(what: Any) -> bool:
    """Whether the answer to a question takes long."""
    _found(what)
    return what in _SLOW


def answer(session: Session, what: Any, arguments: Any, buffers: Sequence[bytes] = ()) -> tuple[Any, list[bytes]]:
    """Answer a question with plain data and buffers.

    Raises
    ------
    AirlightError
        For unknown questions and arguments, and whatever the answer raises.
    """
    function = _found(what)
    given = {**dict(arguments or {}), **({"buffers": list(buffers)} if buffers else {})}
    try:
        inspect.signature(function).bind(session, **given)
    except TypeError as error:
        raise ValueRangeError(f"ask {what}", f"has wrong arguments ({error})") from error
    found = function(session, **given)
    return found if isinstance(found, tuple) else (found, [])


def _found(what: Any) -> Answer:
    if not isinstance(what, str) or what.split(".")[0] not in _modules():
        raise ValueRangeError("ask", f"is {what!r:.80}", f"known: {', '.join(_modules())}")
    import_module(f".asked.{what.split('.')[0]}", __package__)
    function = _ANSWERS.get(what)
    if function is None:
        raise ValueRangeError("ask", f"is {what!r:.80}", f"known: {', '.join(sorted(_ANSWERS))}")
    return function


@cache
def _modules() -> tuple[str, ...]:
    from . import asked

    return tuple(sorted(module.name for module in pkgutil.iter_modules(asked.__path__)))
