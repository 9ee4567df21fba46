"""The rules of the search for the heading: branches and constants that do not follow from the linear model. What does a start lose without
one?

A rule is left out of a copy of the sources that is built beside the library; nothing of this is in the library itself.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from studies.mutants.mutated_copy import COPIED, put
from studies.processes import said_by, sundials_source


@dataclass(frozen=True)
class Rule:
    """repairs: what is wrong with the linear model alone. file: in c_src/ins; without: text there, and what replaces it."""

    repairs: str
    file: str
    without: Mapping[str, str]


_LISTED = tomllib.loads(Path(__file__).with_name("rules.toml").read_text(encoding="utf-8"))
RULES = {name: Rule(rule["repairs"], rule["file"], dict(rule["without"])) for name, rule in _LISTED.items()}  # by name


def changed(rule: Rule, source: str) -> str:
    """The source without the rule. Raises UsageError where its text is not found once."""
    for text, other in rule.without.items():
        if source.count(text) != 1:
            raise UsageError(f"{rule.file}: {text.strip()!r} is found {source.count(text)} times, expected once")
        source = source.replace(text, other)
    return source


def library_without(name: str) -> Path:
    """Builds the library without a rule of RULES, in build/rules. Raises UsageError."""
    rule, folder = RULES[name], CHECKOUT / "build" / "rules"
    source, binary = folder / "source", folder / "build"
    spoilt = CHECKOUT / "c_src" / "ins" / rule.file
    for top in (CHECKOUT / entry for entry in COPIED):
        for path in [top] if top.is_file() else sorted(p for p in top.rglob("*") if p.is_file()):
            data = changed(rule, path.read_text()).encode() if path == spoilt else path.read_bytes()
            put(source / path.relative_to(CHECKOUT), data)
    configure = [
        "cmake", "-S", str(source), "-B", str(binary), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DHNAV_BUILD_BENCH=OFF",
        "-DHNAV_BUILD_EXAMPLES=OFF", "-DHNAV_BUILD_TESTS=OFF", f"-DHNAV_SUNDIALS_SOURCE={sundials_source()}",
    ]  # fmt: skip
    for step in (configure, ["cmake", "--build", str(binary), "--target", "hnav"]):
        said_by(step)
    return binary / "c_src" / "libhnav.so"
