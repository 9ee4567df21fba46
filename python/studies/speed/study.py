"""Fetches and builds the peers, links them with the library, and runs each contender."""

from __future__ import annotations

import statistics
import sys
import tarfile
from pathlib import Path

from rich.table import Table

from hnav.cli.console import say, show
from hnav.places import CHECKOUT
from studies.command import Checkout, Rows, titled_table
from studies.counting import ROWS, compile_program, counted, has_valgrind, times_ns, write_samples
from studies.processes import said_by

HERE = Path(__file__).parent
OWN = [HERE / name for name in ("timing.cpp", "own.cpp")]
WORK = CHECKOUT / ".cache" / "speed"
RUNS = 10

# What is printed, what it is given out as, its name for the program, and the peer of equal standing.
CONTENDERS = (
    ("Fusion", "q, float", "fusion", "vqf"),
    ("BasicVQF", "q", "basicvqf", "vqf"),
    ("VQF", "q", "vqf", "vqf"),
    ("AHRS, closed form", "q", "ahrs:q:closed_form", "vqf"),
    ("AHRS, closed form", "q, sigma", "ahrs:sigma:closed_form", "vqf"),
    ("AHRS, ERKStep", "q", "ahrs:q", "vqf"),
    ("AHRS, ERKStep", "q, sigma", "ahrs:sigma", "vqf"),
    ("HREKF, ERKStep", "q", "hrekf:q", "vqf"),
    ("offlineVQF", "q", "offlinevqf", "offlinevqf"),
    ("AHRS smoothed, closed form", "q", "ahrs-smooth:q:closed_form", "offlinevqf"),
    ("AHRS smoothed, ERKStep", "q", "ahrs-smooth:q", "offlinevqf"),
)


def fetched_sources() -> dict[str, Path]:
    """Folders of the peers' sources by name, unpacked. Raises UsageError when they cannot be had."""
    archives, requirements = WORK / "archives", HERE / "requirements.txt"
    if len(list(archives.glob("*.tar.gz"))) < 2:
        only = ["--disable-pip-version-check", "--quiet", "--no-deps", "--no-binary", "vqf,imufusion", "--require-hashes"]
        said_by([sys.executable, "-m", "pip", "download", *only, "-r", requirements, "-d", archives])
    for archive in archives.glob("*.tar.gz"):
        with tarfile.open(archive) as packed:
            packed.extractall(WORK / "sources", filter="data")
    folders = {folder.name.split("-")[0]: folder for folder in (WORK / "sources").iterdir()}
    return {"vqf": folders["vqf"] / "vqf" / "cpp", "fusion": folders["imufusion"] / "Fusion"}


def built_alone(checkout: Path, program: Path) -> Path:
    """The program that runs our filters, linked with the library of a checkout."""
    return compile_program(OWN, program, checkout, [HERE])


def built(checkout: Path, sources: dict[str, Path]) -> Path:
    """The same for any contender."""
    objects = []
    for file in sorted(sources["fusion"].glob("*.c")):
        objects.append(WORK / f"{file.stem}.o")
        said_by(["cc", "-O3", "-c", file, "-o", objects[-1]])
    peers = [HERE / "peers.cpp", *(sources["vqf"] / name for name in ("vqf.cpp", "basicvqf.cpp", "offline_vqf.cpp"))]
    return compile_program([*OWN, *peers], WORK / "timing", checkout, [HERE, *sources.values()], objects)


def instructions(program: Path, samples: Path, rows: int, name: str) -> float:
    """Of a contender, for each row."""
    return counted("timed_run", [program, samples, str(rows), name, "1"]) / rows


def table_of(program: Path, samples: Path, rows: int) -> Table:
    table = titled_table("", "filter | gives", "instructions a sample | ratio | ns of CPU, least | median")
    counts = {}
    if has_valgrind():
        for name in {name for *_, name, _ in CONTENDERS}:
            counts[name] = instructions(program, samples, rows, name)
    for label, outputs, name, peer in CONTENDERS:
        times = times_ns([program, samples, str(rows), name, str(RUNS)])
        count = [f"{counts[name]:.0f}", f"{counts[name] / counts[peer]:.2f}"] if counts else ["-", "-"]
        table.add_row(label, outputs, *count, f"{min(times):.0f}", f"{statistics.median(times):.0f}")
    return table


def command(rows: Rows = ROWS, checkout: Checkout = CHECKOUT) -> None:
    """Instructions and CPU time of a sample, beside VQF and Fusion, all in C or C++."""
    WORK.mkdir(parents=True, exist_ok=True)
    samples = WORK / "samples.bin"
    write_samples(samples, rows)
    program = built(checkout.resolve(), fetched_sources())
    show(table_of(program, samples, rows))
    say("ratio: to VQF; of what sees the future, to offlineVQF")
