"""Options of the library as Python objects: names, choices, units and ranges are those of the library."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, Self, TypeVar

from hnav.errors import HnavValueError, UnknownOptionError, nearest
from hnav.native.library import ffi, library, text

Made = TypeVar("Made", bound="OptionSet")


MEANT = {
    "body": {
        wrong: body
        for body, words in {
            "hand": "phone telephone smartphone head headset vr arm wrist tool",
            "walker": "foot feet shoe pedestrian person human runner waist pocket animal",
            "car": "automobile truck lorry bus van train tram tractor",
            "ship": "boat vessel yacht ferry buoy usv",
            "quadrotor": "drone copter multicopter multirotor hexacopter octocopter helicopter uav",
            "aircraft": "plane airplane aeroplane glider jet fixedwing fixed-wing",
        }.items()
        for wrong in words.split()
    }
}
"""Common words for a choice of an option, and the valid one."""


@dataclass(frozen=True)
class OptionInfo:
    """One option with its properties in the library."""

    name: str
    """"yaw.motion" for one of a struct inside, which the attribute yaw_motion holds."""
    group: str
    """Group of the option: "noise", "start", ..."""
    unit: str
    """"rad", "1/s", ...; empty if it has none."""
    description: str
    """One sentence."""
    reason: str
    """Reason for the default."""
    choices: tuple[str, ...]
    """The permitted names; empty for numbers."""
    choice_descriptions: tuple[str, ...]
    """The meaning of each choice."""
    default: str | float | int | tuple[float | int, ...]
    """Default of the first preset."""
    count: int
    """Number of elements."""
    min: float
    """Smallest value of each number."""
    max: float
    """Largest value of each number."""
    is_integer: bool
    """Whether its numbers are whole; choices are."""
    advanced: bool
    """False for the dozen basic options."""

    @property
    def attribute(self) -> str:
        """The name as Python writes it."""
        return self.name.replace(".", "_")

    def numbers(self, value: object) -> list[float | int]:
        """The value for the C struct: a choice by its name, numbers, or text of numbers with commas between. Raises HnavValueError."""
        if self.choices:
            if not isinstance(value, str) or value not in self.choices:
                raise self._refused(self._wrong_choice(value))
            return [self.choices.index(value)]
        given = value.split(",") if isinstance(value, str) else list(_flat(value))
        if len(given) != self.count:
            raise self._refused(f"{self.attribute} takes {self.count} number{'s' * (self.count > 1)}, not {len(given)}")
        try:
            floats = [float(n) for n in given]
        except (TypeError, ValueError):
            raise self._refused(f"{self.attribute} = {value}: not a number") from None
        if not self.is_integer:
            return floats
        if any(not f.is_integer() for f in floats):
            raise self._refused(f"{self.attribute} = {value}: not a whole number")
        if any(abs(f) >= 2**31 for f in floats):
            raise self._refused(f"{self.attribute} = {value}: it lies between {self.min:g} and {self.max:g}")
        return [int(f) for f in floats]

    def _wrong_choice(self, value: object) -> str:
        meant = MEANT.get(self.attribute, {}).get(str(value).lower())
        cure = f"write {meant}" if meant else f"choose one of {', '.join(self.choices)}"
        return f"{self.attribute} = {value}: {cure}"

    def _refused(self, text: str) -> HnavValueError:
        return HnavValueError("option", text, self.attribute)


def _flat(value: Any) -> Iterator[Any]:
    """Flat numbers of a scalar, a sequence, or rows of numbers."""
    if isinstance(value, Iterable) and not isinstance(value, str) and getattr(value, "shape", None) != ():
        for item in value:
            yield from _flat(item)
    else:
        yield value


@cache
def option_rows(options: str) -> Mapping[str, OptionInfo]:
    """The options of a list by name, in the library's order; options: the list's name for hnav_option."""
    return {info.name: info for info in map(_info, _c_rows(options).values())}


@cache
def _c_rows(options: str) -> Mapping[str, Any]:
    """The rows of the library, by attribute names."""
    name, rows = options.encode(), dict[str, Any]()
    while row := library().hnav_option(name, len(rows)):
        rows[text(row.name).replace(".", "_")] = row
    return rows


def _info(row: Any) -> OptionInfo:
    each = range(row.choice_count)
    choices, meanings = (tuple(text(names[i]) for i in each) for names in (row.choices, row.choice_descriptions))
    return OptionInfo(
        name=text(row.name), group=text(row.group), unit=text(row.unit), description=text(row.description),
        reason=text(row.reason), choices=choices, choice_descriptions=meanings,
        default=_value(row, [row.default_values[i] for i in range(row.count)]), count=row.count, min=row.min, max=row.max,
        is_integer=row.kind != library().HNAV_OPTION_REAL, advanced=bool(row.advanced),
    )  # fmt: skip


def _value(row: Any, numbers: list[float]) -> Any:
    """The Python value: a choice by its name, several numbers as a tuple."""
    if row.kind == library().HNAV_OPTION_CHOICE:
        return text(row.choices[int(numbers[0])])
    found = tuple(map(int, numbers)) if row.kind == library().HNAV_OPTION_INTEGER else tuple(numbers)
    return found if len(found) > 1 else found[0]


class OptionSet:
    """Options as attributes: read, set, printed, compared, copied and pickled by name.

    A choice goes by its name; several numbers are a tuple; numbers are taken as text too, as files and command lines have
    them. A name that does not exist raises UnknownOptionError, an impossible value HnavValueError; what the library says of
    ranges it says when an object is made with the options.
    """

    LIST: ClassVar[str]
    """The list of those without presets, by its name for hnav_option."""

    def __init__(self, **values: object):
        self._fill(self.LIST, None, values)

    def _fill(self, options: str, preset: int | None, values: Mapping[str, object]) -> None:
        defaults = getattr(library(), f"hnav_{options}_defaults")
        made = defaults() if preset is None else defaults(preset)
        struct, before = (ffi.new(f"hnav_{options}_options *", made) for _ in range(2))
        self.__dict__.update(_options=options, _struct=struct, _defaults=before)
        for name, value in values.items():
            setattr(self, name, value)

    @property
    def struct(self) -> Any:
        """The C struct, for calls of the library."""
        return self._struct

    def as_dict(self) -> dict[str, Any]:
        """All options by the names of their attributes."""
        return {name: self._read(self._struct, row) for name, row in _c_rows(self._options).items()}

    def changed(self) -> dict[str, Any]:
        """The options that differ from those of the preset."""
        before = {name: self._read(self._defaults, row) for name, row in _c_rows(self._options).items()}
        return {name: value for name, value in self.as_dict().items() if value != before[name]}

    def _arguments(self) -> tuple[str, ...]:
        """Arguments of the class besides values."""
        return ()

    def _read(self, struct: Any, row: Any) -> Any:
        return _value(row, [library().hnav_option_value(row, struct, i) for i in range(row.count)])

    def _row(self, name: str) -> Any:
        rows = _c_rows(self._options)
        if name not in rows:
            raise UnknownOptionError("option", f"{self._options} has no option {name}{nearest(name, rows)}", name)
        return rows[name]

    # ----------------------------------------------------------------------------------------- as Python objects are

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # copy and pickle query an object before it is filled
            raise AttributeError(name)
        return self._read(self._struct, self._row(name))

    def __setattr__(self, name: str, value: object) -> None:
        row = self._row(name)
        for i, number in enumerate(_info(row).numbers(value)):
            library().hnav_set_option_value(row, self._struct, i, number)

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{name}: an option can be set, not deleted")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *_c_rows(self._options)]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, OptionSet):
            return NotImplemented
        return self._options == other._options and self.as_dict() == other.as_dict()

    def __repr__(self) -> str:
        parts = [*map(repr, self._arguments()), *(f"{name}={value!r}" for name, value in self.changed().items())]
        return f"{type(self).__name__}({', '.join(parts)})"

    def __copy__(self) -> Self:
        """Copies the struct: going by names, as pickle does, would take longer than ten rows of a run."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__ | {"_struct": ffi.new(f"hnav_{self._options}_options *", self._struct[0])})
        return other

    def __reduce__(self) -> tuple[Any, ...]:
        return _made_again, (type(self), self._arguments(), self.changed())


def _made_again(kind: Callable[..., Made], arguments: tuple[str, ...], values: dict[str, Any]) -> Made:
    return kind(*arguments, **values)


def complete(kind: Callable[..., Made], options: Made | None, values: Mapping[str, object]) -> Made:
    """A copy of the options, or, without them, those of a kind with these values. Raises HnavValueError for both at once."""
    if options is None:
        return kind(**values)
    if values:
        raise HnavValueError("option", f"{kind.__name__} are complete: values belong to {kind.__name__}(...)")
    return copy(options)
