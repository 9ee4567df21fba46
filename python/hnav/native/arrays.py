"""NumPy arrays for the library and structs of the library as dataclasses of numbers and arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.native.library import ffi, new
from hnav.numbers import floats

Array = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
ByteArray = npt.NDArray[np.uint8]
R = TypeVar("R", bound="Record")


def doubles(values: npt.ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    """The values in the layout of C: float64, row by row. Raises HnavValueError for another shape or for values that are no
    numbers.
    """
    array = _numbers(values, name)
    if array.shape != shape:
        raise HnavValueError("size", f"{name} has the shape {array.shape}, expected {shape}", name)
    return array


def times(values: npt.ArrayLike) -> Array:
    """n times in s, for any n; datetime64 since 1970, timedelta64 by its unit; otherwise like doubles."""
    given = np.asarray(values)
    if given.dtype.kind in "mM":
        given = given.astype(f"{given.dtype.kind}8[ns]")
        values = (given - np.zeros(1, given.dtype)) / np.timedelta64(1, "s")
    array = _numbers(values, "t_s")
    if array.ndim != 1:
        cure = ": of samples at equal intervals np.arange(n) / rate_hz" if array.ndim == 0 else ""
        raise HnavValueError("size", f"t_s has the shape {array.shape}, expected (n,){cure}", "t_s")
    return array


def rows_of_three(values: npt.ArrayLike, name: str) -> Array:
    """n x 3 for any n; otherwise like doubles."""
    array = _numbers(values, name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise HnavValueError("size", f"{name} has the shape {array.shape}, expected (n, 3)", name)
    return array


def _numbers(values: npt.ArrayLike, name: str) -> Array:
    try:
        return np.asarray(floats(values), order="C")
    except (TypeError, ValueError):
        cure = ": give its arrays, or a filter run_recording(recording)" if hasattr(values, "rate_b_rad_s") else ""
        raise HnavValueError("size", f"{name} is no array of numbers but a {type(values).__name__}{cure}", name) from None


def stretches(flags: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First row of each stretch of marked ones, and the row after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def address(array: npt.NDArray[Any] | None) -> Any:
    """Pointer to the first number, null for None; C reads float64, and uint8 for bool and uint8. The caller keeps the array."""
    if array is None:
        return ffi.NULL
    return ffi.from_buffer("double[]" if array.dtype == np.float64 else "uint8_t[]", array)


# --------------------------------------------------------------------------------------------- records


# Annotations of the fields of a Record: each makes what Python has of what the library has.


def shaped(*shape: int) -> Callable[[Any], Array]:
    """Numbers with these axes."""
    return lambda numbers: np.array(list(numbers)).reshape(shape)


def named(names: tuple[str, ...]) -> Callable[[int], str]:
    """A number in the library, a name in Python."""
    return names.__getitem__


def counted(names: tuple[str, ...]) -> Callable[[Any], dict[str, int]]:
    """A count for each of these names."""
    return lambda counts: dict(zip(names, counts))


def each(names: tuple[str, ...], record: type[R]) -> Callable[[Any], dict[str, R]]:
    """A Record of this class for each of these names."""
    return lambda structs: dict(zip(names, map(record.read, structs)))


def letters(letters: str) -> Callable[[int], str]:
    """Bits, lowest first, that stand for these letters; Python has the letters of the set bits."""
    return lambda bits: "".join(letter for i, letter in enumerate(letters) if bits >> i & 1)


class Record:
    """A dataclass with fields of a C struct: numbers, flags as bool, arrays of NumPy."""

    @classmethod
    def read(cls: type[R], struct: Any, **more: Any) -> R:
        """From a C struct with these fields, except those given separately."""
        values = {name: reader(getattr(struct, name)) for name, reader in _readers(cls).items() if name not in more}
        return cls(**values, **more)

    def struct(self, kind: str) -> Any:
        """The C struct with these fields."""
        return new(kind, **{name: v.tolist() if isinstance(v, np.ndarray) else v for name, v in vars(self).items()})

    def __eq__(self, other: object) -> bool:
        """Equal numbers in every field; NaN is equal to NaN."""
        if type(other) is not type(self):
            return NotImplemented
        return all(_equal(value, getattr(other, name)) for name, value in vars(self).items())


_READERS: dict[type[Any], dict[str, Callable[[Any], Any]]] = {}


def _readers(cls: type[Any]) -> dict[str, Callable[[Any], Any]]:
    """The function that converts each field from its C value."""
    if cls not in _READERS:
        _READERS[cls] = {name: _reader(hint) for name, hint in get_type_hints(cls, include_extras=True).items()}
    return _READERS[cls]


def _reader(hint: Any) -> Callable[[Any], Any]:
    if get_origin(hint) is Annotated:
        reader: Callable[[Any], Any] = get_args(hint)[1]
        return reader
    return shaped(-1) if hint == Array else hint


def _equal(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray | float) and isinstance(b, np.ndarray | float):
        return np.array_equal(a, b, equal_nan=True)
    return a == b
