"""Parameter sets of SSP 1.0 (SSV files) from plain values.

    write_parameter_set(path, "nominal", {"sensor.seed": 3, "turntable.yaw.unknown_rad": 0.7}, units)

Names are component.parameter, as a set that is bound at the system has them. Numbers are written so that
reading gives the same bits.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
# Exponents of the base units. Units with roots have none and are not declared: a name tells them.
BASE_UNITS: dict[str, dict[str, int]] = {
    "s": {"s": 1}, "1/s": {"s": -1}, "rad": {"rad": 1}, "rad/s": {"rad": 1, "s": -1}, "rad/s2": {"rad": 1, "s": -2},
    "rad2": {"rad": 2}, "rad2/s": {"rad": 2, "s": -1}, "rad2/s2": {"rad": 2, "s": -2}, "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2}, "m/s3": {"m": 1, "s": -3}, "T": {"kg": 1, "s": -2, "A": -1}, "T/s": {"kg": 1, "s": -3, "A": -1},
}  # fmt: skip


def unit_elements(units: set[str], indent: str) -> str:
    """ssc:Unit elements of those that have base units."""
    lines = []
    for name in sorted(units & set(BASE_UNITS)):
        base = " ".join(f'{key}="{value}"' for key, value in BASE_UNITS[name].items())
        lines.append(f"{indent}<ssc:Unit name={quoteattr(name)}><ssc:BaseUnit {base}/></ssc:Unit>\n")
    return "".join(lines)


def value_element(value: bool | int | float, unit: str = "") -> str:
    if isinstance(value, bool):
        return f'<ssv:Boolean value="{str(value).lower()}"/>'
    if isinstance(value, int):
        return f'<ssv:Integer value="{value}"/>'
    declared = f" unit={quoteattr(unit)}" if unit in BASE_UNITS else ""
    return f'<ssv:Real value="{value!r}"{declared}/>'


def parameter_set(name: str, values: Mapping[str, bool | int | float], units: Mapping[str, str], description: str = "") -> str:
    """The SSV text. units: by parameter, "" or missing for none."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>\n<ssv:ParameterSet version="1.0" name=', quoteattr(name)]
    if description:
        lines.append(f" description={quoteattr(description)}")
    lines.append(f'\n    xmlns:ssv="{SSV}"\n    xmlns:ssc="{SSC}">\n  <ssv:Parameters>\n')
    for parameter, value in values.items():
        lines.append(
            f"    <ssv:Parameter name={quoteattr(parameter)}>{value_element(value, units.get(parameter, ''))}</ssv:Parameter>\n"
        )
    lines.append("  </ssv:Parameters>\n")
    used = {units.get(p, "") for p, v in values.items() if isinstance(v, float)}
    if used & set(BASE_UNITS):
        lines.append("  <ssv:Units>\n" + unit_elements(used, "    ") + "  </ssv:Units>\n")
    lines.append("</ssv:ParameterSet>\n")
    return "".join(lines)


def write_parameter_set(
    path: Path, name: str, values: Mapping[str, bool | int | float], units: Mapping[str, str], description: str = ""
) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(parameter_set(name, values, units, description))
