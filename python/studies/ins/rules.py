"""The rules of the search for the heading: branches and constants that do not follow from the linear model. What does a start lose without
one?

A rule is left out of a copy of the sources that is built beside the library; nothing of this is in the library itself.
"""

from __future__ import annotations

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


RULES = {
    "leave_vertical_bias": Rule(
        "products of bias and tilt, linearised about one heading after the other, make the bias about the vertical look observable",
        "any_heading.cpp",
        {"    if (m.channel == velocity || m.channel == position) leave_vertical_bias(s, gyro_before, P, error);\n": ""},
    ),
    "turn_what_was_gathered": Rule(
        "the tilt by biases was gathered about axes that have turned since",
        "any_heading.cpp",
        {"    turn_what_was_gathered(s, P, vec(shift + row_phi));\n": ""},
    ),
    "products": Rule(
        "turning a place and a velocity changes them along their own direction too",
        "any_heading.cpp",
        {"        by[row][0] = by[row + 1][1];\n        by[row + 1][0] = -by[row][1];\n": ""},
    ),
    "gate_given_heading": Rule(
        "the mean of u is short, so that an outlier looks like any other sample",
        "correct.cpp",
        {"    if (is_free(s)) gate_given_heading(s, P, m);\n": ""},
    ),
    "velocity_fits": Rule(
        "a velocity that is wrong by metres a second fits some heading",
        "correct_satellites.cpp",
        {"free && !velocity_fits(s, event)": "false"},
    ),
    "position_jumped": Rule(
        "a position that jumps fits some heading",
        "correct_satellites.cpp",
        {"free && position_jumped(s, event)": "false"},
    ),
    "refuted": Rule(
        "tilt and biases have followed a first fix that was wrong",
        "correct.cpp",
        {
            "        // Tilt and biases have followed the first fixes, or have stepped since.\n"
            "        s.refuted = first_were_wrong(s, m.channel, event.t_s) ? Refuted::first_fixes : Refuted::state;\n"
            "        return;\n": ""
        },
    ),
    "noise_of_turned_biases": Rule(
        "unknown biases in axes that are found to stand otherwise",
        "correct.cpp",
        {"P[row_accel + i][row_accel + j] += more(i, j);": "(void)more;"},
    ),
    "widened": Rule(
        "errors of the linearisation make innovations larger than the noise",
        "model.hpp",
        {"    return std::fmax(1, s.nis_mean / by_chance);": "    return (void)s, (void)by_chance, 1;"},
    ),
    "wrong_heading": Rule(
        "a heading from elsewhere may be wrong by any angle",
        "circle.cpp",
        {"wrong_share = 1e-4": "wrong_share = 1e-300"},
    ),
    "springs": Rule(
        "a car pitches on its springs, so that it moves up in its own axes",
        "correct_speed.cpp",
        {"springs_rad = 0.01": "springs_rad = 0"},
    ),
}
"""By name."""


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
