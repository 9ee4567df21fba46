"""What describes an FMU, written from one table of its variables: modelDescription.xml of FMI 2 and 3, terminals, a page for people.

For FMUs whose variables belong to the user's plant. The binary reads the same table as text, and token() ties the two together.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from xml.sax.saxutils import escape, quoteattr

from hnav.io.model_description import DIMENSIONS, Unit

# As in the enumerations of fmu/adapter/variable.hpp.
TYPES = ("real", "integer", "boolean", "enumeration")
CAUSALITIES = ("independent", "parameter", "calculatedParameter", "input", "output", "local")
_ELEMENTS = {2: ("Real", "Integer", "Boolean", "Enumeration"), 3: ("Float64", "Int32", "Boolean", "Enumeration")}
_NAME_BYTES = 63  # the longest name that the binary can hold
_FNV = 14695981039346656037, 1099511628211
_STRUCTURED = re.compile(r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?(\.[A-Za-z_]\w*(\[\d+(,\d+)*\])?)*|time|der\(.*\)")
_INF = math.inf
_HEADINGS = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters", "local": "Continuous states"}  # of the page


@dataclass(frozen=True)
class Row:
    """A variable; its place in the table, counted from 1, is its value reference."""

    role: str
    """The role of the variable in the binary."""
    index: int
    """Number of the sensor, the input, ...; 0 if there is only one."""
    name: str
    text: str
    type: str = "real"
    causality: str = "output"
    variability: str = "discrete"
    unit: str = ""
    start: float = 0.0
    """Start value of inputs and parameters."""
    min: float = -_INF
    max: float = _INF
    choices: tuple[tuple[str, str], ...] = ()
    """Names and descriptions of an enumeration."""
    derivative_of: int | None = None
    """The state of a derivative, as its place counted from 0."""
    is_state: bool = False
    is_indicator: bool = False
    is_difference: bool = False
    """A difference of two values: the offset of its unit does not apply."""
    depends_on: tuple[int, ...] | None = ()
    """Places of the states that it depends on, counted from 0; None: on all."""


@dataclass(frozen=True)
class About:
    """The properties of an FMU as a whole."""

    name: str
    identifier: str
    description: str
    step_s: float
    stop_s: float
    serialises_state: bool = True
    """A saved state can be restored in another process; in the same process it always can."""
    once: bool = False
    """Only one instance for each process."""
    needs_step_completion: bool = False
    """In Model Exchange the importer must report each completed integrator step."""
    offers_exchange: bool = True
    """Model Exchange beside Co-Simulation."""


def token(rows: Iterable[Row]) -> str:
    """The GUID or instantiation token, computed like the binary computes it from its own table."""
    value, prime = _FNV
    for row in rows:
        for byte in (*row.name.encode()[:_NAME_BYTES], TYPES.index(row.type), CAUSALITIES.index(row.causality)):
            value = (value ^ byte) * prime % 2**64
    low, middle, high = value & 0xFFFF, value >> 16 & 0xFFFF, value >> 48
    tail = value >> 8 & 0xFFFFFFFF
    return f"{{{value >> 32:08x}-{middle:04x}-{low:04x}-{high:04x}-{value >> 24 & 0xFFFF:04x}{tail:08x}}}"


def number(value: float) -> str:
    """The shortest text that parses to the same number."""
    return f"{value:.0f}" if value == round(value) and abs(value) < 1e10 else repr(float(value))


def _attributes(**values: object) -> str:
    """The attributes that are not None, as XML."""
    texts = {name: str(v).lower() if isinstance(v, bool) else v for name, v in values.items() if v is not None}
    return "".join(f" {name}={quoteattr(number(v) if isinstance(v, float) else str(v))}" for name, v in texts.items())


# --------------------------------------------------------------------------------------------- modelDescription.xml


def model_description(about: About, rows: Sequence[Row], units: dict[str, Unit], fmi: int) -> str:
    """units: the units of the variables that have a known SI base."""
    structured = all(_STRUCTURED.fullmatch(row.name) for row in rows)
    head = _attributes(
        fmiVersion="2.0" if fmi == 2 else "3.0", modelName=about.name, **{"guid" if fmi == 2 else "instantiationToken": token(rows)},
        description=about.description, generationTool="hnav", variableNamingConvention="structured" if structured else "flat",
        numberOfEventIndicators=sum(row.is_indicator for row in rows) if fmi == 2 else None,
    )  # fmt: skip
    parts = [
        '<?xml version="1.0" encoding="UTF-8"?>', f"<fmiModelDescription{head}>", *_interfaces(about, fmi), *_units(rows, units),
        *_choices(rows, fmi), "  <LogCategories>",
        '    <Category name="logStatusError" description="What was wrong with a call; always on"/>',
        '    <Category name="logStatusWarning" description="What loses samples, said once; always on"/>',
        '    <Category name="logEvents" description="Initialisation, events, reset, end; on when logging is"/>',
        "  </LogCategories>",
        f"  <DefaultExperiment{_attributes(startTime=0.0, stopTime=about.stop_s, tolerance=1e-8, stepSize=about.step_s)}/>",
        "  <ModelVariables>", *(_variable(row, reference, fmi) for reference, row in enumerate(rows, 1)), "  </ModelVariables>",
        *_structure(rows, fmi), "</fmiModelDescription>", "",
    ]  # fmt: skip
    return "\n".join(parts)


def _interfaces(about: About, fmi: int) -> list[str]:
    state = "FMUstate" if fmi == 2 else "FMUState"
    both = dict(modelIdentifier=about.identifier, canBeInstantiatedOnlyOncePerProcess=about.once or None)
    both |= {f"canGetAndSet{state}": True, f"canSerialize{state}": about.serialises_state or None}
    both |= {"canNotUseMemoryManagementFunctions": True if fmi == 2 else None}
    needed = about.needs_step_completion
    exchange = {"completedIntegratorStepNotNeeded": not needed} if fmi == 2 else {"needsCompletedIntegratorStep": needed}
    steps = {"hasEventMode": True, "providesIntermediateUpdate": True} if fmi == 3 else {}
    return [
        *([f"  <ModelExchange{_attributes(**both, **exchange)}/>"] if about.offers_exchange else []),
        f"  <CoSimulation{_attributes(**both, canHandleVariableCommunicationStepSize=True, **steps)}/>",
    ]


def _units(rows: Sequence[Row], units: dict[str, Unit]) -> list[str]:
    lines = ["  <UnitDefinitions>"]
    for name in sorted({row.unit for row in rows if row.unit}):
        if (known := units.get(name)) is None:
            lines.append(f"    <Unit name={quoteattr(name)}/>")
            continue
        exponents = {dimension: power for dimension, power in zip(DIMENSIONS, known.dimensions) if power}
        scale = {"factor": known.factor if known.factor != 1 else None, "offset": known.offset if known.offset else None}
        lines.append(f"    <Unit name={quoteattr(name)}><BaseUnit{_attributes(**exponents, **scale)}/></Unit>")
    return [*lines, "  </UnitDefinitions>"]


def _choices(rows: Sequence[Row], fmi: int) -> list[str]:
    begin, end = "<SimpleType{}><Enumeration>", "</Enumeration></SimpleType>"
    if fmi == 3:
        begin, end = "<EnumerationType{}>", "</EnumerationType>"
    lines = []
    for row in rows:
        if row.choices:
            items = "".join(f"<Item{_attributes(name=n, value=k, description=d)}/>" for k, (n, d) in enumerate(row.choices))
            lines.append("    " + begin.format(_attributes(name=f"choice.{row.name}")) + items + end)
    return ["  <TypeDefinitions>", *lines, "  </TypeDefinitions>"]


def _start(row: Row) -> str | None:
    if row.causality not in ("input", "parameter"):
        return None
    return ("true" if row.start else "false") if row.type == "boolean" else number(row.start)


def _variable(row: Row, reference: int, fmi: int) -> str:
    element = _ELEMENTS[fmi][TYPES.index(row.type)]
    initial = {"parameter": "exact", "output": "calculated", "local": "calculated"}.get(row.causality)
    common = _attributes(
        name=row.name, valueReference=reference, description=row.text, causality=row.causality, variability=row.variability,
        initial=initial,
    )  # fmt: skip
    bounded = row.causality == "parameter" and row.type != "boolean"
    derivative = None if row.derivative_of is None else row.derivative_of + 1
    own = _attributes(
        declaredType=f"choice.{row.name}" if row.choices else None, unit=row.unit or None,
        relativeQuantity=(row.is_difference and bool(row.unit)) or None,
        min=number(row.min) if bounded and math.isfinite(row.min) else None,
        max=number(row.max) if bounded and math.isfinite(row.max) else None, start=_start(row), derivative=derivative,
        reinit=row.is_state or None,
    )  # fmt: skip
    if fmi == 3:
        return f"    <{element}{common}{own}/>"
    return f"    <ScalarVariable{common}><{element}{own}/></ScalarVariable>"


def _structure(rows: Sequence[Row], fmi: int) -> list[str]:
    place = "index" if fmi == 2 else "valueReference"  # one number, because value references count the variables from 1

    @cache  # all numbers of a column of an observer's transition depend on the same states
    def dependencies(known: tuple[int, ...] | None) -> str | None:
        return None if known is None else " ".join(str(j + 1) for j in known)

    def listed(element: str, wanted: Iterable[int], initial: bool = False) -> list[str]:
        known = {k: None if initial else dependencies(rows[k].depends_on) for k in wanted}
        return [f"    <{element}{_attributes(**{place: k + 1}, dependencies=on)}/>" for k, on in known.items()]

    outputs = [k for k, row in enumerate(rows) if row.causality == "output"]
    derivatives = [k for k, row in enumerate(rows) if row.derivative_of is not None]
    indicators = [k for k, row in enumerate(rows) if row.is_indicator]
    calculated = [k for k, row in enumerate(rows) if row.causality in ("output", "local") and not row.is_indicator]
    if fmi == 3:
        inside = [
            *listed("Output", outputs), *listed("ContinuousStateDerivative", derivatives),
            *listed("InitialUnknown", calculated, initial=True),
            *listed("EventIndicator", indicators),
        ]  # fmt: skip
    else:
        inside = [
            "    <Outputs>", *listed("Unknown", outputs), "    </Outputs>",
            *(["    <Derivatives>", *listed("Unknown", derivatives), "    </Derivatives>"] if derivatives else []),
            "    <InitialUnknowns>", *listed("Unknown", calculated, initial=True), "    </InitialUnknowns>",
        ]  # fmt: skip
    return ["  <ModelStructure>", *inside, "  </ModelStructure>"]


# --------------------------------------------------------------------------------------------- what belongs to it


def terminals(rows: Iterable[Row]) -> str:
    """terminalsAndIcons.xml: inputs and outputs with the same prefix before the first dot form one terminal, except counts."""
    plugs = dict[str, list[str]]()
    for row in rows:
        plug, dot, _ = row.name.partition(".")
        if dot and plug != "count" and row.causality in ("input", "output"):
            plugs.setdefault(plug, []).append(row.name)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>', '<fmiTerminalsAndIcons fmiVersion="3.0">', "  <GraphicalRepresentation>",
        '    <CoordinateSystem x1="-100" y1="-100" x2="100" y2="100" suggestedScalingFactorTo_mm="0.1"/>',
        '    <Icon x1="-100" y1="-100" x2="100" y2="100"/>', "  </GraphicalRepresentation>", "  <Terminals>",
    ]  # fmt: skip
    for plug, names in plugs.items():
        lines.append(f"    <Terminal{_attributes(name=plug, matchingRule='plug')}>")
        for name in names:
            member = _attributes(variableName=name, memberName=name.removeprefix(plug + "."), variableKind="signal")
            lines.append(f"      <TerminalMemberVariable{member}/>")
        lines.append("    </Terminal>")
    return "\n".join([*lines, "  </Terminals>", "</fmiTerminalsAndIcons>", ""])


def page(title: str, paragraphs: Iterable[str], rows: Sequence[Row]) -> str:
    """documentation/index.html."""
    lines = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">',
        f"<title>{escape(title)}</title>",
        "<style>body{font:16px/1.5 sans-serif;max-width:72em;margin:2em auto;padding:0 1em}p{max-width:44em}table{border-collapse:collapse;"
        "font-size:90%}td,th{border:1px solid #ccc;padding:.2em .6em;text-align:left;vertical-align:top}th{background:#f3f3f3}</style></head><body>",
        f"<h1>{escape(title)}</h1>", *(f"<p>{escape(text)}</p>" for text in paragraphs),
    ]  # fmt: skip
    for causality, heading in _HEADINGS.items():
        lines.append(f"<h2>{heading}</h2>\n<table><tr><th>name</th><th>unit</th><th>start</th><th>meaning</th></tr>")
        for row in rows:
            if row.causality == causality:
                cells = (f"<code>{escape(row.name)}</code>", escape(row.unit), _start(row) or "", escape(row.text))
                lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        lines.append("</table>")
    return "\n".join([*lines, "</body></html>", ""])
