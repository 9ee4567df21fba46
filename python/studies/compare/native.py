"""A C library of either side, by the headers of that side: functions, structs and options as they are declared there.

cffi reads what the C preprocessor makes of the headers. Structs are made for the argument that a function declares, and
one that begins with its size gets it; so neither the names of types nor their layout are written down here.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI, CDefError, FFIError
from numpy.typing import NDArray

from hnav.native.headers import declarations
from studies.compare.names import Names

MESSAGE_BYTES = 400
CData = Any  # what cffi makes, and its types
Array = NDArray[Any]
# Fields that say nothing about the answer.
SILENT = {"size", "stamp", "cookie", "reserved"}


class Refused(Exception):
    """A call answered with a status other than OK."""

    def __init__(self, status: int, message: str):
        self.status = status
        super().__init__(f"status {status}: {message}")


class Library:
    def __init__(self, path: Path, include: Path, names: Names):
        self.names, self.ffi = names, FFI()
        self.ffi.cdef(declarations(include))
        self._lib = self.ffi.dlopen(str(path))
        self._functions: dict[str, CData] = {}
        self._types: dict[CData, np.dtype[Any]] = {}
        self._kept: weakref.WeakKeyDictionary[CData, list[Any]] = weakref.WeakKeyDictionary()

    def function(self, name: str) -> CData:
        """By its old or its new name. Raises KeyError."""
        if name not in self._functions:
            known = [c for c in self.names.candidates("call", name) if self.has_function(c)]
            if not known:
                raise KeyError(f"there is no call {name}")
            self._functions[name] = getattr(self._lib, known[0])
        return self._functions[name]

    def has_function(self, name: str) -> bool:
        """By this name, not another."""
        return hasattr(self._lib, name)

    def has_type(self, name: str) -> bool:
        try:
            return bool(self.ffi.typeof(name))
        except (CDefError, FFIError):
            return False

    def argument(self, function: str, index: int) -> CData:
        """A zero struct for a pointer argument of a function."""
        return self.new(self.ffi.typeof(self.function(function)).args[index].item)

    def new(self, kind: CData) -> CData:
        struct = self.ffi.new(self.ffi.getctype(kind, "*"))
        if kind.fields and kind.fields[0][0] == "size":
            struct.size = self.ffi.sizeof(kind)
        return struct

    def pointer(self, array: Array | None) -> CData:
        """To the numbers of a C-contiguous array, which the caller keeps; null for None."""
        if array is None:
            return self.ffi.NULL
        return self.ffi.from_buffer("uint8_t[]" if array.dtype == np.uint8 else "double[]", array)

    def assign(self, struct: CData, values: Mapping[str, Any]) -> None:
        """Fields by name, old or new. Arrays and lists of dictionaries become pointers that live as long as the struct,
        dictionaries are the fields of a struct inside."""
        kept = self._kept.setdefault(struct, [])
        self._assign(struct, values, kept)

    def _assign(self, struct: CData, values: Mapping[str, Any], kept: list[Any]) -> None:
        fields = {name: info.type for name, info in self.ffi.typeof(struct).item.fields}
        for name, value in values.items():
            found = self.names.find("field", name, fields)
            if isinstance(value, dict):
                self._assign(self.ffi.addressof(struct, found), value, kept)
            elif isinstance(value, np.ndarray):
                kept.append(value)
                setattr(struct, found, self.ffi.cast(fields[found], value.ctypes.data))
            elif isinstance(value, list):
                items = self.ffi.new(self.ffi.getctype(fields[found].item, "[]"), len(value))
                kept.append(items)
                for i, item in enumerate(value):
                    self._assign(self.ffi.addressof(items, i), item, kept)
                setattr(struct, found, items)
            else:
                setattr(struct, found, value)

    def layout(self, kind: CData) -> np.dtype[Any]:
        """The numbers of a struct as NumPy sees them, by canonical name; nested structs by dots."""
        if kind not in self._types:
            names, formats, offsets = [], [], []
            for name, number, offset in self._leaves(kind, "", 0):
                names.append(name)
                formats.append(number)
                offsets.append(offset)
            self._types[kind] = np.dtype(
                {"names": names, "formats": formats, "offsets": offsets, "itemsize": self.ffi.sizeof(kind)}
            )
        return self._types[kind]

    def _leaves(self, kind: CData, prefix: str, base: int) -> Iterator[tuple[str, Any, int]]:
        for name, info in kind.fields:
            if name in SILENT or name.startswith("reserved") or info.type.kind == "pointer":
                continue
            path = prefix + self.names.canonical("option", self.names.canonical("field", name))
            if info.type.kind == "struct":
                yield from self._leaves(info.type, path + ".", base + info.offset)
            else:
                yield path, self._number(info.type), base + info.offset

    def _number(self, kind: CData) -> Any:
        """What NumPy calls a number or an array of numbers."""
        if kind.kind == "array":
            return (self._number(kind.item), (kind.length,))
        if kind.kind == "enum":
            return np.dtype(np.int32)
        letter = "f" if kind.cname in ("double", "float") else "u" if kind.cname.startswith("uint") else "i"
        return np.dtype(f"{letter}{self.ffi.sizeof(kind)}")

    def numbers(self, struct: CData) -> dict[str, Array]:
        """The fields of a struct, copied."""
        row = np.frombuffer(bytes(self.ffi.buffer(struct)), self.layout(self.ffi.typeof(struct).item))[0]
        return {name: np.array(row[name]) for name in row.dtype.names or ()}


# --------------------------------------------------------------------------------------------- options


class OptionRow:
    """A row of an option table."""

    def __init__(self, ffi: FFI, row: CData):
        self.name, self.unit = ffi.string(row.name).decode(), ffi.string(row.unit).decode()
        self.choices = [ffi.string(row.choices[i]).decode() for i in range(row.choice_count)]
        self.offset, self.min, self.max, self.count = row.offset, row.min, row.max, row.count
        self.is_integer, self.min_is_open = row.kind != 0, row.min_is_open


def option_rows(library: Library, kind: str) -> dict[str, OptionRow]:
    """The table of a filter or simulated thing by the names that it has there; empty where there is no table."""
    try:
        function = library.function(f"hnav_{kind}_option")
    except KeyError:
        return {}
    rows: dict[str, OptionRow] = {}
    while row := function(len(rows)):
        read = OptionRow(library.ffi, row[0])
        rows[read.name] = read
    return rows


class Options:
    """The options of a filter or simulated thing, from its defaults; values go in by name, choices as text."""

    def __init__(self, library: Library, kind: str, preset: str = "default", **values: Any):
        self._library, self._rows = library, option_rows(library, kind)
        function = library.function(f"hnav_{kind}_defaults")
        presets = [["default", "paper"].index(preset)] if library.ffi.typeof(function).args else []
        made = function(*presets)
        self.struct = library.ffi.new(library.ffi.getctype(library.ffi.typeof(made), "*"), made)
        for name, value in values.items():
            self.set(name, value)

    def _place(self, name: str) -> tuple[CData, OptionRow | None]:
        """A pointer to the numbers of an option, and its row where there is a table."""
        ffi, names = self._library.ffi, self._library.names
        if self._rows:
            row = self._rows[names.find("option", name, self._rows)]
            at = ffi.cast("char *", self.struct) + row.offset
            return ffi.cast("int32_t *" if row.is_integer else "double *", at), row
        fields = dict(ffi.typeof(self.struct).item.fields)
        found = names.find("option", name, fields)
        return ffi.addressof(self.struct, found), None

    def set(self, name: str, value: Any) -> None:
        place, row = self._place(name)
        if isinstance(value, str) and row:
            value = row.choices.index(self._library.names.find("choice", value, row.choices))
        for i, number in enumerate(np.ravel(value).tolist()):
            place[i] = number

    def get(self, name: str) -> Array:
        place, row = self._place(name)
        return np.array([place[i] for i in range(row.count if row else 1)])


# --------------------------------------------------------------------------------------------- objects


class Object:
    """An object of the library, whose functions are hnav_KIND_...; destroyed with this one."""

    def __init__(self, library: Library, kind: str, create: str, *arguments: Any):
        self.library, self._kind = library, kind
        function, ffi = library.function(create), library.ffi
        handle, message = ffi.new(ffi.typeof(function).args[0]), ffi.new("char[]", MESSAGE_BYTES)
        status = function(handle, *arguments, message, MESSAGE_BYTES)
        if status:
            raise Refused(status, ffi.string(message).decode())
        self._handle = ffi.gc(handle[0], library.function(f"hnav_{kind}_destroy"))

    def status(self, name: str, *arguments: Any) -> int:
        """The status that a call answers."""
        status: int = self.library.function(f"hnav_{self._kind}_{name}")(self._handle, *arguments)
        return status

    def call(self, name: str, *arguments: Any) -> None:
        """Raises Refused."""
        if status := self.status(name, *arguments):
            text = self.library.function(f"hnav_{self._kind}_message")(self._handle)
            raise Refused(status, self.library.ffi.string(text).decode())

    def text(self, name: str) -> str:
        text = self.library.function(f"hnav_{self._kind}_{name}")(self._handle)
        return str(self.library.ffi.string(text).decode())

    def array(self, name: str, *shape: int) -> Array:
        """What a call with one output array writes; NaN where it refuses."""
        values = np.full(shape, np.nan)
        if self.status(name, self.library.pointer(values)):
            values[...] = np.nan
        return values

    def save(self) -> bytes:
        size = self.library.ffi.new("size_t *")
        self.call("state_size", size)
        buffer = self.library.ffi.new("char[]", size[0])
        self.call("save", buffer, size[0])
        return bytes(self.library.ffi.buffer(buffer))

    def load(self, state: bytes) -> None:
        self.call("load", self.library.ffi.from_buffer(state), len(state))


class Log:
    """What structs and arrays held, row after row, as one column for each field."""

    def __init__(self, library: Library):
        self._library = library
        self._structs: dict[str, tuple[CData, list[bytes]]] = {}
        self._arrays: dict[str, list[Any]] = {}

    def struct(self, name: str, struct: CData) -> None:
        rows = self._structs.setdefault(name, (self._library.ffi.typeof(struct).item, []))[1]
        rows.append(bytes(self._library.ffi.buffer(struct)))

    def add(self, name: str, value: Any) -> None:
        self._arrays.setdefault(name, []).append(value)

    def columns(self) -> dict[str, Array]:
        found = {name: np.array(values) for name, values in self._arrays.items()}
        for name, (kind, rows) in self._structs.items():
            table = np.frombuffer(b"".join(rows), self._library.layout(kind))
            found |= {f"{name}.{field}": np.ascontiguousarray(table[field]) for field in table.dtype.names or ()}
        return found
