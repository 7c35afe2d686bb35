"""Python that draws again what is seen."""

from __future__ import annotations

from ..asking import answers
from ..script import script
from ..session import Session


@answers("code")
def code(session: Session) -> dict[str, str]:
    """The script, and what to call it."""
    return {"name": "view.py", "text": script(session.document, session.size_px)}
