"""What can go wrong: every error of hnav is a HnavError, and the ValueError or RuntimeError that Python users expect as well.

try:
    filter.push_mag(t_s, field)
except ValueError as error:         # or hnav.HnavError
    print(error, error.status)      # mag: the field is a zero vector ... · zero vector
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

# The statuses of the library about a state, a solver or memory; the others are about an argument.
_OF_THE_STATE = frozenset({
    "out of memory", "late sample", "queue full", "time backwards", "not started", "no data", "solver", "unsupported",
})  # fmt: skip


class HnavError(Exception):
    """A call failed; the text says what was wrong, where, and what to do.

    Raised as HnavValueError or HnavRuntimeError.
    """

    status: str
    """The C status in words: "option", "size", "late sample", ... (HNAV_ERROR_LATE_SAMPLE in hnav/types.h)."""

    argument: str | None
    """The argument or option at fault, whose name stands in the text ("filter = x: choose one of ..."); None if it is none.

    A command line that has another name for it can put its own in this place."""

    def __init__(self, status: str, text: str, argument: str | None = None):
        super().__init__(text)
        self.status, self.argument = status, argument

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.status, str(self), self.argument)


class HnavValueError(HnavError, ValueError):
    """An argument, an option or a file is wrong; the same call fails again."""


class UnknownOptionError(HnavValueError, AttributeError):
    """There is no option of this name; the message proposes one. It is an AttributeError, so hasattr and getattr with a default work."""


class HnavRuntimeError(HnavError, RuntimeError):
    """The arguments are right, but the object's state, its solver or the memory does not let the call succeed."""


class PlausibilityWarning(UserWarning):
    """Samples cannot be what a filter takes them for, such as rates in deg/s or a force in g: its estimate would be meaningless."""


def error_of(status: str, text: str, argument: str | None = None) -> HnavError:
    """The error for a status of the library."""
    return (HnavRuntimeError if status in _OF_THE_STATE else HnavValueError)(status, text, argument)


def nearest(name: str, known: Iterable[str]) -> str:
    """ "; did you mean NAME?" for the end of a message about an unknown name; "" if no known name is near.

    A name in a group is also found by its last word, robust.gamma by gamma, and an incomplete name by its begin.
    """
    names = list(known)
    begun = [n for n in names if n.startswith(f"{name}_")]
    near = [n for n in names if n.endswith(f".{name}")] or begun[:1] or difflib.get_close_matches(name, names, n=1)
    return f"; did you mean {near[0]}?" if len(near) == 1 else ""
