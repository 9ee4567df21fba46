"""Work shared out to processes, and programs that are run."""

from __future__ import annotations

import importlib.util
import os
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

from hnav.cli.words import UsageError
from hnav.places import CHECKOUT

Item = TypeVar("Item")
Found = TypeVar("Found")


def in_order(judge: Callable[[Item], Found], items: Iterable[Item], workers: int, chunk: int = 1) -> Iterator[Found]:
    """Results of judge for each item, in their order, for any number of workers; 1: in this process.

    chunk: items that a worker is given at once.
    """
    if workers == 1:
        yield from map(judge, items)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(judge, items, chunksize=chunk)


def said_by(command: Sequence[str | Path], **where: Any) -> str:
    """What a program prints; where: as of subprocess.run. Raises UsageError with the end of what it complains about."""
    done: subprocess.CompletedProcess[str] = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, check=False, **where
    )
    if done.returncode:
        raise UsageError(f"{' '.join(map(str, command[:3]))} failed:\n{(done.stderr or done.stdout).strip()[-1500:]}")
    return done.stdout


def sundials_source() -> Path | str:
    given = os.environ.get("HNAV_SUNDIALS_SOURCE")
    return given or next((CHECKOUT / "build/sundials/source").glob("sundials-*"), "")


def fmi_headers() -> Path | str:
    """Without them the library has no plants of FMUs."""
    found = importlib.util.find_spec("fmpy")
    return Path(str(found.origin)).parent / "c-code" if found else ""
