"""The C library by cffi: where it lies, structs and enumerations as the headers declare them, objects that live in it.

hnav/native/_hnav.py holds the declarations; hnav.native.headers makes it from c_src/include when hnav is built, so nothing
of a struct is written down in Python. cffi releases the interpreter's lock during a call: objects run in parallel threads,
each of them in one thread at a time.
"""

from __future__ import annotations

import os
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from hnav.errors import HnavError, HnavRuntimeError, error_of
from hnav.places import CHECKOUT, PACKAGE

try:
    from hnav.native._hnav import ffi as ffi
except ModuleNotFoundError as error:
    if error.name != "hnav.native._hnav":
        raise
    raise ImportError(
        "hnav/native/_hnav.py is missing: ./run build makes it from the C headers (cmake --build build --target python_binding)"
    ) from None

MESSAGE_BYTES = 320
FILE = {"win32": "libhnav.dll", "darwin": "libhnav.dylib"}.get(sys.platform, "libhnav.so")

# --------------------------------------------------------------------------------------------- the library


def library_path() -> Path:
    """HNAV_LIBRARY, else the library in this package (installed), else the build of the checkout."""
    given = os.environ.get("HNAV_LIBRARY")
    if given:
        return Path(given)
    for candidate in (PACKAGE / FILE, CHECKOUT / "build" / "c_src" / FILE):
        if candidate.is_file():
            return candidate
    raise HnavRuntimeError("unsupported", f"{FILE} is not built: ./run build makes it, or set HNAV_LIBRARY to its path")


@cache
def library() -> Any:
    """The C functions, as attributes. Raises HnavRuntimeError when the library cannot be loaded."""
    path = library_path()
    try:
        return ffi.dlopen(str(path))
    except OSError as error:
        raise HnavRuntimeError("unsupported", f"{path} cannot be loaded: {error}") from None


def version() -> str:
    """MAJOR.MINOR.PATCH of the library."""
    return text(library().hnav_version())


def text(characters: Any) -> str:
    """The text of a C string."""
    return str(ffi.string(characters).decode())


# --------------------------------------------------------------------------------------------- structs and enumerations


def enumerators(name: str, prefix: str) -> tuple[str, ...]:
    """The names of an enumeration in the order of their numbers, without the prefix, in small letters."""
    elements: dict[int, str] = ffi.typeof(name).elements
    return tuple(elements[number].removeprefix(prefix).lower() for number in range(len(elements)))


def _status_in_words(enumerator: str) -> str:
    words = enumerator.removeprefix("error_").replace("_", " ")
    return words.replace("non ", "non-").replace("ill ", "ill-")


STATUSES = tuple(_status_in_words(name) for name in enumerators("hnav_status", "HNAV_"))
SENSORS = enumerators("hnav_sensor", "HNAV_SENSOR_")
PRESETS = enumerators("hnav_preset", "HNAV_PRESET_")


@cache
def _begins_with_its_size(kind: str) -> bool:
    fields = ffi.typeof(kind).fields
    return bool(fields) and fields[0][0] == "size"


def new(kind: str, **values: Any) -> Any:
    """A pointer to a new struct, zero but for its size and these fields.

    An address among the values must live as long as the struct: the struct does not keep it.
    """
    struct = ffi.new(f"{kind} *")
    if _begins_with_its_size(kind):
        struct.size = ffi.sizeof(kind)
    for name, value in values.items():
        setattr(struct, name, value)
    return struct


# --------------------------------------------------------------------------------------------- objects


# An error text of the library about an option begins with the option name, for arrays with an index.
_OPTION = re.compile(r"(?P<name>[a-z_][\w.]*)(\[\d+\])? = ", re.IGNORECASE)


def message_buffer() -> Any:
    """For calls that write the reason of a failure into a buffer of the caller."""
    return ffi.new("char[]", MESSAGE_BYTES)


def failure(status: int, message: Any) -> HnavError:
    """The error for a status that is not OK, with the reason as a C string."""
    reason = text(message)
    named = _OPTION.match(reason) if STATUSES[status] == "option" else None
    argument = named["name"] if named else None
    return error_of(STATUSES[status], reason, argument)


class LibraryObject:
    """An object of the C library whose functions are hnav_KIND_...; it is destroyed with this one.

    One object serves one thread at a time; different objects run in parallel threads.
    """

    KIND: ClassVar[str]

    def __init__(self, create: str, *arguments: Any):
        lib = library()
        handle, message = ffi.new(f"hnav_{self.KIND} **"), message_buffer()
        status = getattr(lib, create)(handle, *arguments, message, len(message))
        if status:
            raise failure(status, message)
        self._handle = ffi.gc(handle[0], getattr(lib, f"hnav_{self.KIND}_destroy"))

    def _call(self, name: str, *arguments: Any) -> None:
        """hnav_KIND_name(object, arguments). Raises HnavError with the object's message."""
        self._do(f"hnav_{self.KIND}_{name}", *arguments)

    def _do(self, function: str, *arguments: Any) -> None:
        """The same for a function by its full name."""
        lib = library()
        status = getattr(lib, function)(self._handle, *arguments)
        if status:
            raise failure(status, getattr(lib, f"hnav_{self.KIND}_message")(self._handle))

    def _filled(self, kind: str, name: str, *arguments: Any) -> Any:
        """A new struct of this kind that hnav_KIND_name(object, arguments, struct) has filled."""
        return self._filled_by(f"hnav_{self.KIND}_{name}", kind, *arguments)

    def _filled_by(self, function: str, kind: str, *arguments: Any) -> Any:
        """The same for a function by its full name."""
        struct = new(kind)
        self._do(function, *arguments, struct)
        return struct


class StatefulObject(LibraryObject):
    """An object that processes samples: it is reset, saved and loaded."""

    def reset(self) -> None:
        """Back to the moment after creation: no samples, no estimate, counters zero."""
        self._call("reset")

    def save(self) -> bytes:
        """The state as bytes: numbers only, which any object made with equal arguments loads, in any process.

        It goes on from there bit for bit.
        """
        size = ffi.new("size_t *")
        self._call("state_size", size)
        state = bytearray(size[0])
        self._call("save", ffi.from_buffer(state, require_writable=True), len(state))
        return bytes(state)

    def load(self, state: bytes) -> None:
        """Takes the state that save gave. Raises HnavValueError when it is damaged, of another version, or of an object
        made with other arguments; the object then stays as it was."""
        self._call("load", ffi.from_buffer(state), len(state))


def continued(kind: type[StatefulObject], made_of: tuple[Any, ...], state: bytes) -> StatefulObject:
    """An object created from these arguments that continues from a saved state; called by copy and pickle."""
    made = kind(*made_of)
    made.load(state)
    return made
