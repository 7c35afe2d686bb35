"""Questions that clients ask of a session: each is a function in a module of ``asked``, found by its name.

A new one is a file: ``asked/histogram.py`` answers ``histogram``, and ``histogram.joint`` where there is a second.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import ValueRangeError

if TYPE_CHECKING:
    from .session import Session

Answer = Callable[..., Any]
F = TypeVar("F", bound=Answer)
_ANSWERS: dict[str, Answer] = {}


def answers(what: str) -> Callable[[F], F]:
    """Decorate the function that answers a question: ``function(session, **arguments)`` returns plain data.

    Or a pair of plain data and a list of bytes, which clients get as buffers. It runs on the session's worker thread.
    """

    def kept(function: F) -> F:
        _ANSWERS[what] = function
        return function

    return kept


def answer(session: Session, what: Any, arguments: Any) -> tuple[Any, list[bytes]]:
    """Answer a question with plain data and buffers.

    Raises
    ------
    AirlightError
        For unknown questions and arguments, and whatever the answer raises.
    """
    if not isinstance(what, str) or what.split(".")[0] not in _modules():
        raise ValueRangeError("ask", f"is {what!r:.80}", f"known: {', '.join(_modules())}")
    import_module(f".asked.{what.split('.')[0]}", __package__)
    function = _ANSWERS.get(what)
    if function is None:
        raise ValueRangeError("ask", f"is {what!r:.80}", f"known: {', '.join(sorted(_ANSWERS))}")
    try:
        found = function(session, **dict(arguments or {}))
    except TypeError as error:
        raise ValueRangeError(f"ask {what}", f"has wrong arguments ({error})") from error
    return found if isinstance(found, tuple) else (found, [])


def _modules() -> tuple[str, ...]:
    from . import asked

    return tuple(sorted(module.name for module in pkgutil.iter_modules(asked.__path__)))
