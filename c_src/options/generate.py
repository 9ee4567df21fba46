"""Writes what follows from the option lists: the public headers and the tables of the library.

    ./run generate      after a change of a list; a test fails when it was forgotten

A list, NAME.toml beside this file, is the one place that defines an option of hnav_NAME_options:

    name, number, text      what the struct is called, the number of the list in its stamp, what it is
    [presets]               choices: which choices name the presets; NAME.text, NAME.values: what differs from the defaults
    [groups]                the groups in the order of the struct, each with a sentence
    [structs]               groups whose options are fields of a struct inside, with the type of that struct
    [choices.NAME]          prefix of the C names, text, items.ITEM = its meaning; enum: the C type, hnav_NAME if not said
    [shared.NAME]           what several options of this list share
    [GROUP.NAME]            an option:
        text        one sentence without a full stop
        unit        as in "rad/s", none if not said
        range       "[min, max]", a round bracket on the side that is excluded
        default     a number, an array of them, or the name of a choice; text such as "60 deg", "2 pi", "pi/2" is a number too
        reason      why the default is what it is
        choices     the choices that it is one of
        type        "integer"; otherwise a number is a double
        advanced    false for those that a user meets first

What an option does not say it takes from [shared.NAME] of its list, then from shared.toml.
"""

from __future__ import annotations

import math
import re
import sys
import textwrap
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
HEADERS = HERE.parent / "include" / "hnav" / "options"
LISTS = (
    "ahrs", "hrekf", "ins", "ins_error", "magnetometer", "turntable", "imu_mag_sensor", "vehicle", "aid_sensor", "aircraft", "observer",
)  # fmt: skip
MADE = "Made by c_src/options/generate.py from {}: change that, then ./run generate."
WIDTH = 120  # of the text of a comment
CODE_WIDTH = 130


# --------------------------------------------------------------------------------------------- lists


class ListError(Exception):
    """A list says something impossible; the text names the list and the option."""


@dataclass(frozen=True)
class Choices:
    name: str
    enum: str  # the C type
    prefix: str
    text: str
    items: dict[str, str]  # name to meaning, in the order of the enum

    def constant(self, item: str) -> str:
        return f"{self.prefix}_{item.upper()}"


@dataclass(frozen=True)
class Option:
    group: str
    name: str  # of the field
    inside: bool  # a field of a struct inside, which is called as the group
    text: str
    unit: str
    range: str
    min: float
    max: float
    min_is_open: bool
    max_is_open: bool
    default: tuple[float, ...]
    shown: str  # the default as the list has it
    reason: str
    choices: Choices | None
    integer: bool
    advanced: bool

    @property
    def path(self) -> str:
        """As the C library and Python name it: "yaw.motion" for a field of a struct inside."""
        return f"{self.group}.{self.name}" if self.inside else self.name


@dataclass(frozen=True)
class Preset:
    name: str
    value: int  # of the enum
    text: str
    values: dict[str, tuple[float, ...]]  # what differs from the defaults


@dataclass(frozen=True)
class OptionList:
    name: str
    number: int
    text: str
    groups: dict[str, str]
    structs: dict[str, str]
    choices: dict[str, Choices]  # its own
    options: tuple[Option, ...]
    presets: tuple[Preset, ...]
    shared_choices: bool = field(default=False)  # it names choices of shared.toml

    @property
    def struct(self) -> str:
        return f"hnav_{self.name}_options"


def read_choices(tables: dict[str, Any]) -> dict[str, Choices]:
    return {
        name: Choices(name, table.get("enum", f"hnav_{name}"), table["prefix"], table["text"], table["items"])
        for name, table in tables.items()
    }


class Written(float):
    """A number that remembers how the list writes it."""

    text: str

    def __new__(cls, text: str) -> Written:
        self = super().__new__(cls, text)
        self.text = text
        return self


def written(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(written, value))
    return (value.text if isinstance(value, Written) else str(value)).removesuffix(".0")


def read_toml(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(), parse_float=Written)


def number(value: float | str) -> float:
    """A number as lists have it: 0.1, "60 deg", "-2 pi", "pi/2", "inf"."""
    if not isinstance(value, str):
        return float(value)
    found = re.fullmatch(r"(-?)([\d.eE+-]*)\s*(pi|deg|inf)?(?:/(\d+))?", value)
    if not found or not (found[2] or found[3]):
        raise ValueError(f"{value!r} is no number")
    units = {None: 1.0, "pi": math.pi, "deg": math.pi / 180, "inf": math.inf}
    size = float(found[2] or 1) * units[found[3]] / float(found[4] or 1)
    return -size if found[1] else size


def read_range(text: str) -> tuple[float, float, bool, bool]:
    found = re.fullmatch(r"([\[(])([^,]+), ([^,]+)([\])])", text)
    if not found:
        raise ValueError(f"range = {text!r}: write it as [min, max] or (min, max]")
    return number(found[2]), number(found[3]), found[1] == "(", found[4] == ")"


def values_of(value: Any, choices: Choices | None) -> tuple[float, ...]:
    if choices:
        return (float(list(choices.items).index(value)),)
    return tuple(number(v) for v in value) if isinstance(value, list) else (number(value),)


def make_option(group: str, name: str, inside: bool, said: dict[str, Any], choices: dict[str, Choices]) -> Option:
    chosen = choices[said["choices"]] if "choices" in said else None
    default = values_of(said["default"], chosen)
    span = f"[0, {len(chosen.items) - 1}]" if chosen else said["range"]
    low, high, low_open, high_open = read_range(span)
    for v in default:
        if not (low < v if low_open else low <= v) or not (v < high if high_open else v <= high):
            raise ValueError(f"default {v:g} is outside {span}")
    return Option(
        group, name, inside, said["text"], said.get("unit", ""), span, low, high, low_open, high_open, default, written(said["default"]),
        said["reason"], chosen, said.get("type") == "integer", said.get("advanced", True),
    )  # fmt: skip


def read_presets(table: dict[str, Any], choices: dict[str, Choices], options: tuple[Option, ...]) -> tuple[Preset, ...]:
    by_name = {option.path: option for option in options}
    presets = []
    for value, name in enumerate(choices[table["choices"]].items if table else ()):
        if name in table:
            differs = {n: values_of(v, by_name[n].choices) for n, v in table[name].get("values", {}).items()}
            presets.append(Preset(name, value, table[name]["text"], differs))
    return tuple(presets) or (Preset("default", 0, "The defaults.", {}),)


def read_list(name: str, folder: Path = HERE) -> OptionList:
    """Raises ListError."""
    common = read_toml(folder / "shared.toml")
    data = read_toml(folder / f"{name}.toml")
    own = read_choices(data.get("choices", {}))
    choices = read_choices(common["choices"]) | own
    structs = data.get("structs", {})
    options = []
    for group in data["groups"]:
        for option, said in data.get(group, {}).items():
            inside = group.split(".")[0] in structs
            try:
                said = common.get(option, {}) | data.get("shared", {}).get(option, {}) | said
                options.append(make_option(group, option, inside, said, choices))
            except (KeyError, ValueError) as error:
                raise ListError(f"{name}.toml: {group}.{option}: {error}") from None
    unknown = set(data) - set(data["groups"]) - {"name", "number", "text", "presets", "groups", "structs", "choices", "shared"}
    if unknown:
        raise ListError(f"{name}.toml: {unknown.pop()} is no group")
    try:
        presets = read_presets(data.get("presets", {}), choices, tuple(options))
    except (KeyError, ValueError) as error:
        raise ListError(f"{name}.toml: presets: {error}") from None
    borrowed = any(o.choices and o.choices.name not in own for o in options)
    return OptionList(name, data["number"], data["text"], data["groups"], structs, own, tuple(options), presets, borrowed)


# --------------------------------------------------------------------------------------------- headers


def comment(*texts: str, indent: str = "") -> str:
    """A C comment, each text of which begins on a line of its own."""
    width = WIDTH - len(indent)
    lines = [line for text in texts for line in textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)]
    return "\n".join(f"{indent}{' * ' if i else '/* '}{line}" for i, line in enumerate(lines)) + " */\n"


def enum(choices: Choices) -> str:
    last = len(choices.items) - 1
    values = [f"{choices.constant(item)} = {i}{',' * (i < last)}" for i, item in enumerate(choices.items)]
    width = max(map(len, values))
    lines = [f"    {value:<{width}} /* {meaning} */\n" for value, meaning in zip(values, choices.items.values())]
    return f"{comment(choices.text)}typedef enum {choices.enum} {{\n{''.join(lines)}}} {choices.enum};\n"


def declaration(option: Option, indent: str) -> str:
    """A field and what is to be known of it."""
    unit = f" {option.unit}" if option.unit else ""
    values = option.choices.enum if option.choices else f"{option.range}{unit}"
    about = f"{values}, default {option.shown}. {option.reason}"
    kind = "int32_t" if option.integer or option.choices else "double"
    count = f"[{len(option.default)}]" if len(option.default) > 1 else ""
    return comment(f"{option.text}.", about, indent=indent) + f"{indent}{kind} {option.name}{count};\n"


def members(options: list[Option], prefix: str, groups: dict[str, str], indent: str) -> str:
    """The fields below a path; structs inside that have no type of their own are written where they stand."""
    text = ""
    for group in groups:
        here = [o for o in options if o.group == group]
        if group == prefix:
            text += "".join(declaration(o, indent) for o in here)
        elif group.startswith(f"{prefix}."):
            name = group[len(prefix) + 1 :]
            text += f"\n{comment(groups[group], indent=indent)}{indent}struct {{\n"
            text += "".join(declaration(o, indent + "    ") for o in here) + f"{indent}}} {name};\n"
    return text.lstrip("\n")


def inner_structs(spec: OptionList) -> str:
    text, done = "", {}
    for group, kind in spec.structs.items():
        body = members(list(spec.options), group, spec.groups, "    ")
        if kind in done:
            continue
        done[kind] = body
        about = spec.groups[group] if list(spec.structs.values()).count(kind) == 1 else "What each axis has."
        text += f"{comment(about)}typedef struct {kind} {{\n{body}}} {kind};\n\n"
    return text


def outer_struct(spec: OptionList) -> str:
    about = f'Make them with hnav_{spec.name}_defaults, then change what you need; hnav_option("{spec.name}", i) states all this at run time.'
    text = f"{comment(spec.text, about)}typedef struct {spec.struct} {{\n"
    text += f"    size_t size;    /* of this struct in bytes; set by hnav_{spec.name}_defaults */\n"
    text += "    uint64_t stamp; /* the list and the version of the library that made it; set likewise */\n"
    for group, about in spec.groups.items():
        if group in spec.structs:
            text += f"\n    {spec.structs[group]} {group}; /* {about[0].lower()}{about[1:].rstrip('.')} */\n"
        elif group.split(".")[0] not in spec.structs:
            text += f"\n{comment(f'------------------------ {group}', about, indent='    ')}\n"
            text += "".join(declaration(o, "    ") for o in spec.options if o.group == group)
    return text + f"}} {spec.struct};\n"


def header(name: str, source: str, includes: list[str], body: str) -> str:
    guard = f"HNAV_OPTIONS_{name.upper()}_H"
    lines = "".join(f"#include {include}\n" for include in includes)
    return f"/* {MADE.format(source)} */\n#ifndef {guard}\n#define {guard}\n\n{lines}\n{body}\n#endif /* {guard} */\n"


def shared_header() -> str:
    shared = read_choices(read_toml(HERE / "shared.toml")["choices"])
    return header("shared", "shared.toml", [], "\n".join(map(enum, shared.values()))).replace("\n\n\n", "\n\n")


def list_header(spec: OptionList) -> str:
    includes = ['"hnav/options/shared.h"\n'] if spec.shared_choices else []
    enums = "".join(f"{enum(c)}\n" for c in spec.choices.values())
    return header(
        spec.name, f"{spec.name}.toml", [*includes, "<stddef.h>", "<stdint.h>"], enums + inner_structs(spec) + outer_struct(spec)
    )


# --------------------------------------------------------------------------------------------- tables


def literal(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def prose(text: str) -> str:
    """Text that only readers need: the small build leaves it out."""
    return f"text({literal(text)})"


def real(value: float) -> str:
    return (
        ("-INFINITY" if value < 0 else "INFINITY")
        if math.isinf(value)
        else f"{value:.17g}"
        if value != float(f"{value:g}")
        else f"{value:g}"
    )


def packed(items: Iterable[str]) -> str:
    """Lines with as many items as fit."""
    lines: list[str] = []
    for item in items:
        if lines and len(lines[-1]) + len(f" {item},") <= CODE_WIDTH:
            lines[-1] += f" {item},"
        else:
            lines.append(f"    {item},")
    return "".join(f"{line}\n" for line in lines)


def choice_arrays(choices: Iterable[Choices], kind: str) -> str:
    """Names and meanings of the items, of the C++ type `kind`."""
    text = ""
    for c in choices:
        meanings = packed(map(prose, c.items.values()))
        text += (
            f"{kind} {c.name}_names[] = {{{', '.join(map(prose, c.items))}}};\n{kind} {c.name}_meanings[] = {{\n{meanings}}};\n"
        )
    return text


def row(spec: OptionList, option: Option, first: int) -> str:
    c = option.choices
    kind = "CHOICE" if c else "INTEGER" if option.integer else "REAL"
    names, count = (f"{c.name}_names, {c.name}_meanings", len(c.items)) if c else ("nullptr, nullptr", 0)
    items = (
        f"{{{literal(option.path)}", prose(option.group), prose(option.unit), prose(option.text), prose(option.reason), names,
        f"defaults + {first}", f"offsetof({spec.struct}, {option.path})", real(option.min), real(option.max),
        str(len(option.default)), str(count), f"HNAV_OPTION_{kind}", str(int(option.min_is_open)), str(int(option.max_is_open)),
        f"{int(option.advanced)}}}",
    )  # fmt: skip
    return packed(items)


def preset_arrays(spec: OptionList) -> str:
    index = {option.path: i for i, option in enumerate(spec.options)}
    arrays, rows = "", ""
    for preset in spec.presets:
        entries = [(index[n], i, v, n) for n, values in preset.values.items() for i, v in enumerate(values)]
        if entries:
            lines = "".join(f"    {{{k}, {i}, {real(v)}}}, // {n}\n" for k, i, v, n in entries)
            arrays += f"\n// Row, component, value.\nconstexpr PresetValue {preset.name}_values[] = {{\n{lines}}};\n"
        values = f"{preset.name}_values, {len(entries)}" if entries else "nullptr, 0"
        rows += f"    {{{{{literal(preset.name)}, {prose(preset.text)}, {preset.value}}}, {values}}},\n"
    return f"{arrays}\nconstexpr Preset presets[] = {{\n{rows}}};\n"


def table(spec: OptionList) -> str:
    rows, first = "", 0
    for option in spec.options:
        rows += row(spec, option, first)
        first += len(option.default)
    defaults = packed(real(v) for option in spec.options for v in option.default)
    named = {option.choices.name for option in spec.options if option.choices}
    arrays = choice_arrays((c for c in spec.choices.values() if c.name in named), "const char* const")
    lists = "choices" if spec.shared_choices else "lists"
    return (
        f"// {MADE.format(f'{spec.name}.toml')}\n"
        f'#include "options/{lists}.hpp"\n\n#include "hnav/options/{spec.name}.h"\n\n#include <cmath>\n#include <cstddef>\n\n'
        f"// clang-format off\nnamespace hnav {{\nnamespace {{\n\n{arrays}{chr(10) if arrays else ''}"
        f"// Of all rows, one after the other.\nconstexpr double defaults[] = {{\n{defaults}}};\n\n"
        f"const OptionRow rows[] = {{\n{rows}}};\n{preset_arrays(spec)}\n}} // namespace\n\n"
        f"const OptionList {spec.name}_options = {{\n"
        f'    "hnav_{spec.name}_defaults", {spec.number}, sizeof({spec.struct}), rows, {len(spec.options)}, '
        f"presets, {len(spec.presets)}}};\n\n}} // namespace hnav\n"
    )


def choices_header(specs: list[OptionList]) -> str:
    """Choices of shared.toml that are those of an option; presets are none."""
    named = {option.choices.name: option.choices for spec in specs for option in spec.options if option.choices}
    own = {name for spec in specs for name in spec.choices}
    arrays = choice_arrays((c for name, c in named.items() if name not in own), "inline constexpr const char*")
    return (
        f"// {MADE.format('shared.toml')}\n#pragma once\n\n"
        f'#include "options/lists.hpp"\n\n// clang-format off\nnamespace hnav {{\n\n{arrays}\n}} // namespace hnav\n'
    )


def lists_header(specs: list[OptionList]) -> str:
    lines = "".join(f"extern const OptionList {spec.name}_options;\n" for spec in specs)
    return (
        f"// {MADE.format('the lists')}\n#pragma once\n\n"
        f'#include "base/option_list.hpp"\n#include "base/small.hpp"\n\nnamespace hnav {{\n\n{lines}\n'
        "// Descriptions for a reader; the small build has no room for them.\n"
        'constexpr const char* text(const char* description) { return small_build ? "" : description; }\n\n'
        "} // namespace hnav\n"
    )


# --------------------------------------------------------------------------------------------- files


def generate() -> dict[Path, str]:
    """Every file that is made, with its text. Raises ListError."""
    specs = [read_list(name) for name in LISTS]
    files = {
        HEADERS / "shared.h": shared_header(),
        HERE / "lists.hpp": lists_header(specs),
        HERE / "choices.hpp": choices_header(specs),
    }
    for spec in specs:
        files[HEADERS / f"{spec.name}.h"] = list_header(spec)
        files[HERE / f"{spec.name}.cpp"] = table(spec)
    return files


def main() -> int:
    try:
        files = generate()
    except ListError as error:
        print(error, file=sys.stderr)
        return 1
    for path, text in files.items():
        path.parent.mkdir(exist_ok=True)
        if not path.is_file() or path.read_text() != text:
            path.write_text(text)
            print(path.relative_to(HERE.parents[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
