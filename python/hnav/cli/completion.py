"""Completions of the Tab key: names of filters, options, engines, systems, scenarios and grades.

hnav --install-completion sets it up for bash, zsh, fish and PowerShell. These modules are loaded at each Tab.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from hnav.errors import HnavError


def starting(words: Iterable[str], incomplete: str) -> list[str]:
    return [word for word in words if word.startswith(incomplete)]


def among(*words: str) -> Callable[[str], list[str]]:
    """Proposes fixed words."""

    def propose(incomplete: str) -> list[str]:
        return starting(words, incomplete)

    return propose


def option_names(ctx: Any, incomplete: str) -> list[str]:
    """NAME= of the filter named before; its choices after it."""
    from hnav.filters.options import option_table

    filter = ctx.params.get("filter") or "ahrs"
    try:
        table = option_table(filter)
    except HnavError:
        return []
    name, separator, _ = incomplete.partition("=")
    if separator:
        return starting((f"{name}={choice}" for choice in table[name].choices), incomplete) if name in table else []
    return starting((f"{info.attribute}=" for info in table.values()), incomplete)


def system_names(incomplete: str) -> list[str]:
    from hnav.systems.ssp_reader import known_systems

    return starting(sorted(known_systems()), incomplete)


def scenario_names(ctx: Any, incomplete: str) -> list[str]:
    return _sets(ctx, "scenarios", incomplete)


def grade_names(ctx: Any, incomplete: str) -> list[str]:
    return _sets(ctx, "grades", incomplete)


def _sets(ctx: Any, kind: str, incomplete: str) -> list[str]:
    """Names for the system named before."""
    from hnav.systems.ssp_reader import read_system, system_path

    # While an option lacks its value, the words before it are not assigned to arguments yet.
    named = ctx.params.get("system") or next(iter(ctx.args), "")
    try:
        with read_system(system_path(named)) as system:
            return starting(getattr(system, kind), incomplete)
    except HnavError:
        return []
