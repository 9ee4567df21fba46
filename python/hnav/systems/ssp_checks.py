"""Checks a system before it runs: connectors and variables, ends of connections, types and units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from fmpy.model_description import ModelDescription

from hnav.errors import nearest
from hnav.systems.structure import Component, Connection, System, refuse, types_agree

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
# Units by name: exponents of the base units, factor and offset.
Units = Mapping[str, tuple[float, ...]]


def check_system(system: System, units: Units) -> None:
    """units: defined in the SSD. Raises HnavError that names the mismatch."""
    for component in system.components.values():
        _check_connectors(component, units)
    for connection in system.connections:
        _check_connection(system, connection, units)
    _check_single_source(system.connections)


def text_of(connection: Connection) -> str:
    return f"{_text_of_end(connection.start)} -> {_text_of_end(connection.end)}"


def _text_of_end(end: tuple[str, str]) -> str:
    return ".".join(filter(None, end))


def _fmu_units(description: ModelDescription) -> Units:
    bases = {unit.name: unit.baseUnit for unit in description.unitDefinitions if unit.baseUnit}
    return {
        name: (*(float(getattr(base, power, 0) or 0) for power in BASE_UNITS), float(base.factor or 1), float(base.offset or 0))
        for name, base in bases.items()
    }


class _End(NamedTuple):
    """An end of a connection; type and unit may be unspecified (empty)."""

    kind: str
    type: str
    unit: str
    units: Units  # where the unit is defined


def _units_agree(one: str, ones: Units, other: str, others: Units) -> bool:
    """Equal names, or names with equal definitions. An unspecified unit agrees with all."""
    return one == other or not one or not other or (one in ones and ones[one] == others.get(other))


def _check_connectors(component: Component, units: Units) -> None:
    fmu_units = _fmu_units(component.description)
    for connector in component.connectors.values():
        variable, full = component.variables.get(connector.name), f"connector {component.name}.{connector.name}"
        if variable is None:
            hint = nearest(connector.name, component.variables)
            refuse(f"{full}: {component.description.modelName} has no variable {connector.name}{hint}")
        if connector.kind in ("input", "output", "parameter") and connector.kind != variable.causality:
            refuse(f"{full} is an {connector.kind} in the SSD and a variable of kind {variable.causality} in the FMU")
        if connector.type and not types_agree(connector.type, variable.kind):
            refuse(f"{full} is {connector.type} in the SSD and {variable.kind} in the FMU")
        if not _units_agree(connector.unit, units, variable.unit, fmu_units):
            refuse(f"{full} is in {connector.unit} in the SSD and in {variable.unit} in the FMU")


def _end(system: System, end: tuple[str, str], units: Units, where: str) -> _End:
    element, name = end
    if element and element not in system.components:
        refuse(f"{where}: there is no element {element}")
    declared = system.components[element].connectors if element else system.connectors
    if name not in declared:
        refuse(f"{where}: {element or f'system {system.name}'} has no connector {name}")
    if not element:
        # Seen from inside, the inputs of the system are sources and its outputs are sinks.
        kind = {"input": "output", "output": "input"}.get(declared[name].kind, declared[name].kind)
        return _End(kind, declared[name].type, declared[name].unit, units)
    component = system.components[element]
    variable = component.variables[name]
    return _End(declared[name].kind, variable.kind, variable.unit, _fmu_units(component.description))


def _check_connection(system: System, connection: Connection, units: Units) -> None:
    """Data flows from an output (or the system's input) to an input (or the system's output) of the same type and unit."""
    where = f"connection {text_of(connection)}"
    start, end = (_end(system, side, units, where) for side in (connection.start, connection.end))
    if (start.kind, end.kind) != ("output", "input"):
        refuse(f"{where}: it runs from an {start.kind} to an {end.kind}; an output to an input is wanted")
    if start.type and end.type and start.type != end.type:
        refuse(f"{where}: {start.type} does not fit {end.type}")
    if not _units_agree(start.unit, start.units, end.unit, end.units):
        refuse(f"{where}: {start.unit} does not fit {end.unit}")


def _check_single_source(connections: list[Connection]) -> None:
    ends: dict[tuple[str, str], Connection] = {}
    for connection in connections:
        other = ends.setdefault(connection.end, connection)
        if other is not connection:
            fed = f"{_text_of_end(connection.end)} is already fed by {_text_of_end(other.start)}"
            refuse(f"connection {text_of(connection)}: {fed}")
