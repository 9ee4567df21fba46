"""Parameter sets of SSP 1.0 (SSV files) from plain values.

    text = parameter_set("nominal", {"sensor.seed": 3, "hekf.robust.gamma_mode": "off"}, variables)

Names are component.parameter, as a set that is bound at the system has them. Numbers are written so that
reading gives the same bits.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

from fmpy.model_description import ScalarVariable

from hnav.fmi.fmus import item_value
from hnav.systems.structure import Value

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
# Exponents of the base units. Units with roots have none and are not declared: only their name is used.
BASE_UNITS: dict[str, dict[str, int]] = {
    "s": {"s": 1}, "1/s": {"s": -1}, "rad": {"rad": 1}, "rad/s": {"rad": 1, "s": -1}, "rad/s2": {"rad": 1, "s": -2},
    "rad2": {"rad": 2}, "rad2/s": {"rad": 2, "s": -1}, "rad2/s2": {"rad": 2, "s": -2}, "m/s": {"m": 1, "s": -1},
    "m": {"m": 1}, "Pa": {"kg": 1, "m": -1, "s": -2}, "m/s2": {"m": 1, "s": -2}, "m/s3": {"m": 1, "s": -3}, "T": {"kg": 1, "s": -2, "A": -1}, "T/s": {"kg": 1, "s": -3, "A": -1},
}  # fmt: skip


def unit_elements(units: set[str], indent: str) -> str:
    """ssc:Unit elements for the units with base units."""
    lines = []
    for name in sorted(units & set(BASE_UNITS)):
        base = " ".join(f'{key}="{value}"' for key, value in BASE_UNITS[name].items())
        lines.append(f"{indent}<ssc:Unit name={quoteattr(name)}><ssc:BaseUnit {base}/></ssc:Unit>\n")
    return "".join(lines)


def parameter_element(name: str, value: Value, variable: ScalarVariable) -> str:
    """ssv:Parameter. An enumeration is written as a number, because fmpy and Ecos read it so; its name is a comment beside
    it.
    """
    if isinstance(value, bool):
        described, element = "", f'<ssv:Boolean value="{str(value).lower()}"/>'
    elif isinstance(value, str):
        described, element = f" description={quoteattr(value)}", f'<ssv:Integer value="{item_value(variable, value)}"/>'
    elif isinstance(value, int):
        described, element = "", f'<ssv:Integer value="{value}"/>'
    else:
        declared = f" unit={quoteattr(variable.unit)}" if variable.unit in BASE_UNITS else ""
        described, element = "", f'<ssv:Real value="{value!r}"{declared}/>'
    return f"<ssv:Parameter name={quoteattr(name)}{described}>{element}</ssv:Parameter>\n"


def parameter_set(name: str, values: Mapping[str, Value], variables: Mapping[str, ScalarVariable], description: str = "") -> str:
    """The SSV text. variables: of the FMUs, by parameter."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>\n<ssv:ParameterSet version="1.0" name=', quoteattr(name)]
    if description:
        lines.append(f" description={quoteattr(description)}")
    lines.append(f'\n    xmlns:ssv="{SSV}"\n    xmlns:ssc="{SSC}">\n  <ssv:Parameters>\n')
    lines += [f"    {parameter_element(parameter, value, variables[parameter])}" for parameter, value in values.items()]
    lines.append("  </ssv:Parameters>\n")
    used = {variables[p].unit or "" for p, v in values.items() if isinstance(v, float)}
    if used & set(BASE_UNITS):
        lines.append("  <ssv:Units>\n" + unit_elements(used, "    ") + "  </ssv:Units>\n")
    lines.append("</ssv:ParameterSet>\n")
    return "".join(lines)
