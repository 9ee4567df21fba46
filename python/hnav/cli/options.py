"""hnav options: the options of a filter with unit, default, range and meaning."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from hnav.cli.console import show
from hnav.cli.parameters import FilterName
from hnav.filters.attitude import Options, option_table


def command(filter: FilterName = "ahrs") -> None:
    defaults = Options(filter)
    table = Table("option", "default", "unit", "range or choices", "meaning")
    for info in option_table(filter).values():
        value = getattr(defaults, info.name)
        shown = value if info.choices else ",".join(f"{v:g}" for v in np.ravel(value))
        allowed = ", ".join(info.choices) or f"{info.min:g} to {info.max:g}"
        table.add_row(info.name, shown, info.unit, allowed, info.description)
    show(table, width=200)
