"""What a sample costs in C: instructions, and time of the processor."""

from __future__ import annotations

import math
import statistics
from pathlib import Path
from typing import Any

from hnav.places import CHECKOUT
from studies.counting import compile_program, counted, has_valgrind, times_ns

WORK = CHECKOUT / ".cache" / "observer"
SAMPLES, RUNS = 200, 50
CASES = {
    "van_der_pol": "van der Pol: interval and correction",
    "falling_ball": "plant with events: interval and correction",
    "bouncing_ball": "the same with a bounce in the interval",
}
BOUNCE = "a bounce with its matrix, and the return of its indicator"


def built() -> Path:
    """The program that runs any case. Raises UsageError."""
    return compile_program([Path(__file__).with_suffix(".cpp")], WORK / "cost", CHECKOUT, [CHECKOUT / "c_src/tests"])


def results(runs: int = RUNS) -> list[dict[str, Any]]:
    """Of a sample of all cases; what a bounce adds is the difference of the last two."""
    program, made = built(), list[dict[str, Any]]()
    for name, case in CASES.items():
        times = [1e-3 * ns for ns in times_ns([program, name, str(runs)])]
        instructions = counted("timed_run", [program, name, "1"]) / SAMPLES if has_valgrind() else math.nan
        made.append({"instructions": instructions, "least_us": min(times), "median_us": statistics.median(times), "case": case})
    without, bouncing = made[-2:]
    return [*made, {"case": BOUNCE} | {figure: bouncing[figure] - without[figure] for figure in list(bouncing)[:3]}]
