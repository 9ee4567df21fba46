"""Small systems that tests write themselves: components of built FMUs, connected by names that match."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import fmpy

from hnav.fmi.fmus import fmu_path

KINDS = {"Real": "Real", "Integer": "Integer", "Boolean": "Boolean", "Enumeration": "Integer"}
HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="{name}" xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
<ssd:System name="{name}">"""
PARAMETER_SET = """<ssv:ParameterSet version="1.0" name="made" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
<ssv:Parameters>{}</ssv:Parameters></ssv:ParameterSet>"""
BINDING = "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>{}</ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
COMPONENT = """<ssd:Component name="{}" type="application/x-fmu-sharedlibrary" source="resources/{}.fmu">
<ssd:Connectors>{}</ssd:Connectors></ssd:Component>"""
KINDS_OF_VALUES = {bool: "Boolean", int: "Integer", float: "Real", str: "Enumeration"}


def parameter_set(values: Mapping[str, object]) -> str:
    """The text of an SSV; True, 1, 1.0 and text become a Boolean, an Integer, a Real and an Enumeration."""
    entry = '<ssv:Parameter name="{}"><ssv:{} value="{}"/></ssv:Parameter>'
    return PARAMETER_SET.format(
        "".join(entry.format(name, KINDS_OF_VALUES[type(v)], str(v).lower()) for name, v in values.items())
    )


def make_system(
    folder: Path,
    components: Mapping[str, str],
    connections: Sequence[tuple[str, str]],
    parameters: Mapping[str, object] | None = None,
    inputs: Mapping[str, str] | None = None,
    name: str = "made",
) -> Path:
    """Writes SystemStructure.ssd into the folder. components: name to FMU; connections: "component.variable" or, of the
    system's inputs, "variable"; a pair ending in * stands for all outputs and inputs of that beginning with one name.
    inputs: connectors of the system and their types.
    """
    folder.mkdir(parents=True, exist_ok=True)
    variables = {
        c: {v.name: v for v in fmpy.read_model_description(str(fmu_path(fmu, 2)), validate=False).modelVariables}
        for c, fmu in components.items()
    }
    pairs = [pair for connection in connections for pair in _expanded(connection, variables)]
    text = [HEAD.format(name=name), "<ssd:Connectors>"]
    text += [f'<ssd:Connector name="{n}" kind="input"><ssc:{kind}/></ssd:Connector>' for n, kind in (inputs or {}).items()]
    text.append("</ssd:Connectors>")
    if parameters:
        text.append(BINDING.format(parameter_set(parameters)))
    text.append("<ssd:Elements>")
    for component, fmu in components.items():
        used = sorted({end.partition(".")[2] for pair in pairs for end in pair if end.partition(".")[0] == component})
        rows = []
        for variable in (variables[component][n] for n in used):
            unit = f' unit="{variable.unit}"' if variable.unit else ""
            rows.append(
                f'<ssd:Connector name="{variable.name}" kind="{variable.causality}"><ssc:{KINDS[variable.type]}{unit}/></ssd:Connector>'
            )
        text.append(COMPONENT.format(component, fmu, "".join(rows)))
    text.append("</ssd:Elements><ssd:Connections>")
    for start, end in pairs:
        ends = [f'{side}Element="{c}" {side}Connector="{v}"' if c in components else f'{side}Connector="{whole}"'
                for side, whole in (("start", start), ("end", end)) for c, _, v in [whole.partition(".")]]  # fmt: skip
        text.append(f"<ssd:Connection {' '.join(ends)}/>")
    text.append("</ssd:Connections></ssd:System></ssd:SystemStructureDescription>")
    (folder / "SystemStructure.ssd").write_text("\n".join(text))
    return folder


def _expanded(connection: tuple[str, str], variables: Mapping) -> list[tuple[str, str]]:
    start, end = connection
    if not start.endswith("*"):
        return [connection]
    (one, stem), (other, _) = (side[:-1].split(".", 1) for side in connection)
    common = [n for n, v in variables[one].items() if n.startswith(stem) and v.causality == "output"]
    return [(f"{one}.{n}", f"{other}.{n}") for n in common if n in variables[other] and variables[other][n].causality == "input"]


SENSORS = ("gyro.", "accel.", "mag.")
# Settings of make_turntable: without noise of its own a run is hardly one.
NOISE = {
    "sensor.gyro.noise_deg_per_sqrt_h": 0.3,
    "sensor.accel.noise_ug_per_sqrt_hz": 200.0,
    "sensor.mag.noise_nt_per_sqrt_hz": 50.0,
}


def make_turntable(folder: Path) -> Path:
    """Turntable -> ImuMagSensor -> Hrekf twice and Ahrs; the scenario gamma_off turns gamma off in both Hrekf."""
    filters = {"hekf": "Hrekf", "hrekf": "Hrekf", "ahrs": "Ahrs"}
    connections = [("turntable.truth.*", "sensor.truth.*"), *((f"sensor.{s}*", f"{f}.{s}*") for f in filters for s in SENSORS)]
    parameters = {f"{name}.sampling_mode": "counter" for name in filters} | {
        "hekf.robust.gamma_mode": "off",
        "hrekf.robust.gamma_mode": "kl",
    }
    make_system(folder, {"turntable": "Turntable", "sensor": "ImuMagSensor", **filters}, connections, parameters)
    (folder / "scenario_gamma_off.ssv").write_text(parameter_set({"hrekf.robust.gamma_mode": "off"}))
    return folder
