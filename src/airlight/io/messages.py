"""What files and libraries say, cut to what fits into one sentence."""

from __future__ import annotations


def brief(error: BaseException) -> str:
    """First line of what an exception says, with its type."""
    lines = str(error).strip().splitlines()
    text = lines[0][:160] if lines else ""
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def shown(text: object) -> str:
    """Text out of a file, quoted and short."""
    whole = str(text)
    return repr(whole if len(whole) <= 60 else whole[:57] + "...")
