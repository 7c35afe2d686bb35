"""The one family of errors: where, what, what is allowed, and the way out."""

from __future__ import annotations


class AirlightError(Exception):
    """What went wrong, told to the user who can mend it.

    Parameters
    ----------
    where
        The thing at fault: a parameter's dotted name, a file, a file and line.
    what
        The finding, e.g. ``"is 1.7, must lie in (0, 1]"``.
    remedy
        What to do instead; a whole phrase, left out where the finding says it.
    """

    def __init__(self, where: str, what: str, remedy: str = "") -> None:
        self.where, self.what, self.remedy = where, what, remedy
        super().__init__(f"{where} {what}" + (f": {remedy}" if remedy else ""))

    def __reduce__(self) -> tuple[type[AirlightError], tuple[str, str, str]]:
        return type(self), (self.where, self.what, self.remedy)


class ValueRangeError(AirlightError, ValueError):
    """A parameter lies outside of what is allowed."""


class DataError(AirlightError, ValueError):
    """An array or a file holds something that cannot be drawn."""


class FileError(AirlightError, OSError):
    """A file is missing, damaged, hostile or of an unknown kind."""

    def __str__(self) -> str:
        return Exception.__str__(self)


class MissingExtraError(AirlightError, ImportError):
    """An optional package is needed; the remedy is the pip command that installs it."""

    def __str__(self) -> str:
        return Exception.__str__(self)


class StageError(AirlightError, TypeError):
    """A stage does not fulfil the contract of its slot."""


class ShaderError(AirlightError):
    """WGSL that does not link or compile; ``where`` is ``file:line``."""


class LimitError(AirlightError):
    """The device or the memory limit is too small; the remedy names the way out."""


class DeviceError(AirlightError, RuntimeError):
    """No adapter answers, or the device was lost or ran out of memory."""
