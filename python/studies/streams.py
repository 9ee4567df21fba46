"""Filters with random options on random streams of samples, watched by the sanitizers; and eight threads at once.

    ./run study streams --streams 10000

Streams hold gaps, bursts of one stamp, late samples, readings beyond all sense and what is no number; resets, saves and loads;
every solver, both attitude filters, the INS error filter (c_src/fuzz/random_streams.cpp says what is looked at). They run under
AddressSanitizer and UndefinedBehaviorSanitizer, the test of threads under ThreadSanitizer, each in a build of its own.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import say
from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from studies.command import tracked
from studies.processes import said_by

SHARE = 50  # streams of one process
STREAMS, THREADS = Path("c_src/tests/random_streams"), Path("c_src/tests/test_threads")


def built(preset: str, program: Path) -> Path:
    """The program in the build of this preset. Raises UsageError."""
    folder = CHECKOUT / f"build-{preset}"
    steps = [["cmake", "--build", "--preset", preset, "--target", program.name]]
    if not (folder / "build.ninja").is_file():
        steps.insert(0, ["cmake", "--preset", preset])
    for step in steps:
        said_by(step, cwd=CHECKOUT)
    return folder / program


def counts_of(program: Path, first: int, count: int) -> Counter[str]:
    """What the last line of the program counts. Raises UsageError with the seed and what was wrong."""
    done = subprocess.run([str(program), str(first), str(count)], capture_output=True, text=True, check=False)
    lines = done.stdout.strip().splitlines() or ["no seed"]
    if done.returncode or done.stderr:
        wrong = re.search(r"does not hold.*|runtime error.*|ERROR:.*", done.stderr)
        raise UsageError(f"{lines[-1]}: {wrong.group() if wrong else f'exit status {done.returncode}'}")
    return Counter({what: int(number) for number, what in re.findall(r"(\d+) ([a-z ]+)", lines[-1])})


def random_streams(program: Path, first: int, streams: int) -> Counter[str]:
    """All of them, on as many processes as there are cores. Raises UsageError at the first that is not clean."""
    total: Counter[str] = Counter()
    shares = [(seed, min(SHARE, first + streams - seed)) for seed in range(first, first + streams, SHARE)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        running = [pool.submit(counts_of, program, *share) for share in shares]
        try:
            for future in tracked(running, f"{SHARE} streams each"):
                total.update(future.result())
        except UsageError:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return total


def command(
    streams: Annotated[int, typer.Option(min=1, help="Random streams, each a filter's life")] = 10000,
    first: Annotated[int, typer.Option(min=0, help="The first seed")] = 0,
    threads: Annotated[bool, typer.Option(help="Eight threads under ThreadSanitizer too")] = True,
) -> None:
    """Ends with the first promise that is broken, and the seed that broke it."""
    say(", ".join(f"{number} {what}" for what, number in random_streams(built("asan", STREAMS), first, streams).items()))
    say("clean under AddressSanitizer and UndefinedBehaviorSanitizer")
    if threads:
        done = subprocess.run([str(built("tsan", THREADS))], capture_output=True, text=True, check=False)
        if done.returncode:
            raise UsageError(f"threads: {(done.stderr.strip().splitlines() or ['a test failed'])[0]}")
        say("8 threads: clean under ThreadSanitizer")
