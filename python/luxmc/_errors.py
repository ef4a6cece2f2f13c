"""Exceptions: one class for each exit code of the command line, with the same messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Optional

if TYPE_CHECKING:
    from ._result import Result


class LuxmcError(Exception):
    """Base class of all errors of luxmc. ``exit_code`` is the exit code of the command line for the same error."""

    exit_code: int = 2


class RefusedError(LuxmcError, ValueError):
    """Invalid input or conflicting options. The message states the fault, its place, what was expected, and a remedy. Exit code 2.

    >>> import luxmc
    >>> try:
    ...     luxmc.Scene.load("no-such-office.json")
    ... except luxmc.RefusedError as error:
    ...     print(error.exit_code, str(error).splitlines()[0])
    2 the scene file cannot be read
    """

    exit_code = 2


class TargetMissedError(LuxmcError):
    """A limit ended the run before its target was met. ``result`` has the results so far. Exit code 3. Only ``Result.check`` raises it."""

    exit_code = 3

    def __init__(self, words: str, result: Optional["Result"] = None) -> None:
        super().__init__(words)
        self.result = result


class UnwrittenError(LuxmcError, OSError):
    """Results could not be written. Exit code 4."""

    exit_code = 4


class RunInterruptedError(LuxmcError):
    """The run was interrupted. ``result`` has the results so far. Exit code 130. Only ``Result.check`` raises it."""

    exit_code = 130

    def __init__(self, words: str, result: Optional["Result"] = None) -> None:
        super().__init__(words)
        self.result = result


# Tracebacks show the classes under the name of the package.
for _class in (LuxmcError, RefusedError, TargetMissedError, UnwrittenError, RunInterruptedError):
    _class.__module__ = "luxmc"
