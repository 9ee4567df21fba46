"""The command: which measurements are made, and what is written of them."""

from __future__ import annotations

import datetime
import os
import platform
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from hnav.cli.console import say
from hnav.cli.words import UsageError
from hnav.io.outputs import write_files
from hnav.places import CHECKOUT
from studies.command import check_choices
from studies.results.tables import json_text, read_printed

TRIALS, FLIGHT = "DIR", "FLIGHT"
FOLDERS = {TRIALS: "BROAD_DIR", FLIGHT: "HNAV_FLIGHT"}
"""Words of a command that stand for a folder, and the variable of the environment that names it."""


class Section(NamedTuple):
    """A measurement. command: as it is typed behind ./run; quick: within two minutes on two cores."""

    title: str
    says: str
    command: str
    quick: bool

    @property
    def needs(self) -> list[str]:
        """Variables of the environment."""
        return [FOLDERS[word] for word in self.command.split() if word in FOLDERS]


_LISTED = tomllib.loads(Path(__file__).with_name("sections.toml").read_text(encoding="utf-8"))
SECTIONS = {name: Section(**fields) for name, fields in _LISTED.items()}


# --------------------------------------------------------------------------------------------- the command


RESULTS = CHECKOUT / "docs" / "results"


def command(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help=", ".join(SECTIONS))] = None,
    everything: Annotated[bool, typer.Option("--all", help="Also what takes longer than two minutes")] = False,
    folder: Annotated[Path, typer.Option(metavar="DIR", help="Where NAME.json is written")] = RESULTS,
) -> None:
    """Measures, and writes docs/results/NAME.json for each measurement."""
    check_choices("there is no measurement", names or (), SECTIONS)
    chosen = names or [name for name, section in SECTIONS.items() if section.quick or everything]
    for name in chosen:
        section = SECTIONS[name]
        if missing := [variable for variable in section.needs if not os.environ.get(variable)]:
            say(f"{name} is left out: {missing[0]} is not set")
            continue
        say(f"{name}: ./run {section.command}")
        result = {
            "title": section.title, "says": section.says, "commands": [section.command], "when": circumstances(),
            "printed": read_printed(answer_of(section)),
        }  # fmt: skip
        write_files({folder / f"{name}.json": json_text(result)})


def answer_of(section: Section) -> str:
    """What the command prints. Raises UsageError when it fails."""
    words = [os.environ[FOLDERS[word]] if word in FOLDERS else word for word in shlex.split(section.command)]
    # The build is that of ./run study, so the modules are called by themselves.
    modules = {"study": ["-m", "studies", *words[1:]], "hnav": ["-m", "hnav", *words[1:]]}
    done = subprocess.run([sys.executable, *modules[words[0]]], capture_output=True, text=True, cwd=CHECKOUT, check=False)
    if done.returncode:
        raise UsageError(f"./run {section.command}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
    return re.sub(r"[ \t]+$", "", done.stdout, flags=re.MULTILINE)


def circumstances() -> str:
    """When, on what machine, of which revision."""
    revision = git("rev-parse", "--short", "HEAD")
    # The pages are what this writes.
    changed = ", changed" if git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs") else ""
    return f"{datetime.date.today()}, {os.cpu_count()} cores of {processor()}, revision {revision}{changed}"


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], capture_output=True, text=True, cwd=CHECKOUT, check=True).stdout.strip()


def processor() -> str:
    """Name of the processor, as reported by the system."""
    cpuinfo = Path("/proc/cpuinfo")
    names = re.findall(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.is_file() else []
    return names[0].strip() if names else platform.machine()
