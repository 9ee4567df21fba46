"""What a sample costs in C: instructions, and time of the processor."""

from __future__ import annotations

import statistics
from dataclasses import dataclass
from pathlib import Path

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


@dataclass(frozen=True)
class Cost:
    """Of a sample."""

    case: str
    instructions: float | None
    least_us: float
    median_us: float


def built() -> Path:
    """The program that runs any case. Raises UsageError."""
    return compile_program([Path(__file__).with_suffix(".cpp")], WORK / "cost", CHECKOUT, [CHECKOUT / "c_src/tests"])


def results(runs: int = RUNS) -> list[Cost]:
    """Of all cases; what a bounce adds is the difference of the last two."""
    program, made = built(), []
    for name, case in CASES.items():
        times = [1e-3 * ns for ns in times_ns([program, name, str(runs)])]
        instructions = counted("timed_run", [program, name, "1"]) / SAMPLES if has_valgrind() else None
        made.append(Cost(case, instructions, min(times), statistics.median(times)))
    without, bouncing = made[-2:]
    more = None if bouncing.instructions is None else bouncing.instructions - (without.instructions or 0)
    return [*made, Cost(BOUNCE, more, bouncing.least_us - without.least_us, bouncing.median_us - without.median_us)]
