"""Builds the filters for a Cortex-M4F, measures them, and runs them in qemu beside this machine."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from hnav.rotations import rotation_error_rad
from studies.command import titled_table
from studies.counting import ROWS, write_samples
from studies.processes import said_by
from studies.speed.study import fetched_sources

HERE = Path(__file__).parent
WORK = CHECKOUT / ".cache" / "small"
TOOLCHAIN = CHECKOUT / "cmake/toolchains/cortex-m4f.cmake"
TOOLS = ("arm-none-eabi-gcc", "arm-none-eabi-g++", "arm-none-eabi-size", "qemu-system-arm", "cmake", "ninja")
CORTEX = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
SMALL = ("-Os", "-ffunction-sections", "-fdata-sections", "-ffp-contract=off")
SECONDS = 60


@dataclass(frozen=True)
class Contender:
    label: str
    scalar: str
    own: str = ""  # ours: the filter in the names of its calls; empty for a peer
    peer: str = ""  # a folder of sources by its name in fetched_sources


CONTENDERS = (
    Contender("AHRS", "float", own="ahrs"),
    Contender("AHRS", "double", own="ahrs"),
    Contender("HREKF", "float", own="hrekf"),
    Contender("HREKF", "double", own="hrekf"),
    Contender("VQF", "float", peer="vqf"),
    Contender("VQF", "double", peer="vqf"),
    Contender("Fusion", "float", peer="fusion"),
)


def missing_tools() -> list[str]:
    """Programs that the study calls and this machine has not."""
    return [tool for tool in TOOLS if shutil.which(tool) is None]


def library(scalar: str, cortex: bool) -> Path:
    """The small build, made if it is not there or stale."""
    folder = WORK / f"{'cortex' if cortex else 'here'}-{scalar}"
    if not (folder / "build.ninja").is_file():
        toolchain = [f"-DCMAKE_TOOLCHAIN_FILE={TOOLCHAIN}"] if cortex else []
        said_by(
            ["cmake", "-S", CHECKOUT, "-B", folder, "-G", "Ninja", "-DHNAV_SMALL=ON", f"-DHNAV_SMALL_SCALAR={scalar}", *toolchain]
        )
    said_by(["cmake", "--build", folder])
    return folder / "c_src/libhnav_small.a"


def parts(contender: Contender, compilers: tuple[str, str], flags: tuple[str, ...], cortex: bool) -> list[str | Path]:
    """Objects and libraries of a contender, behind its calls of contender.h. compilers: of C and C++."""
    folder = WORK / f"{contender.own or contender.peer}-{contender.scalar}-{'cortex' if cortex else 'here'}"
    folder.mkdir(parents=True, exist_ok=True)
    c, cxx = compilers
    if contender.own:
        sources, include, libraries = [HERE / "own.c"], [CHECKOUT / "c_src/include"], [library(contender.scalar, cortex)]
        defines = [f"-DCREATE={contender.own}"]
    else:
        place = fetched_sources()[contender.peer]
        include, libraries = [place], []
        sources = [HERE / "vqf.cpp", place / "vqf.cpp"] if contender.peer == "vqf" else [HERE / "fusion.c", *place.glob("*.c")]
        defines = ["-DVQF_SINGLE_PRECISION"] if contender.scalar == "float" else []
    objects: list[str | Path] = []
    for source in sources:
        objects.append(folder / f"{source.parent.name}-{source.stem}.o")
        language = [cxx, "-std=c++17", "-fno-exceptions", "-fno-rtti"] if source.suffix == ".cpp" else [c, "-std=gnu11"]
        said_by([*language, *flags, *defines, *(f"-I{f}" for f in (HERE, *include)), "-c", source, "-o", objects[-1]])
    return [*objects, *libraries]


def for_cortex(contender: Contender) -> list[str | Path]:
    return parts(contender, ("arm-none-eabi-gcc", "arm-none-eabi-g++"), (*CORTEX, *SMALL), True)


def code_bytes(contender: Contender) -> int:
    """Of a program that does nothing but filter, with all that it calls of the libraries of C."""
    program = WORK / "bare.elf"
    options = ["--specs=nano.specs", "--specs=nosys.specs", "-nostartfiles", "-Wl,--gc-sections,-e,bare"]
    objects = for_cortex(contender)
    said_by(
        ["arm-none-eabi-g++", *CORTEX, *SMALL, "-x", "c", HERE / "bare.c", "-x", "none", *objects, *options, "-lm", "-o", program]
    )
    text, data = said_by(["arm-none-eabi-size", program]).splitlines()[1].split()[:2]
    return int(text) + int(data)


def read_answers(file: Path, rows: int) -> np.ndarray:
    return np.fromfile(file).reshape(rows, 4)


def replay_in_qemu(contender: Contender, samples: Path, rows: int) -> tuple[np.ndarray, int, int]:
    """Attitudes (rows, 4), bytes of the filter and of the stack."""
    folder = WORK / "qemu"
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "replay.elf"
    options: list[str | Path] = ["--specs=rdimon.specs", "-nostartfiles", "-T", HERE / "mps2-an386.ld", "-Wl,--gc-sections"]
    sources: list[str | Path] = ["-x", "c", HERE / "replay.c", HERE / "startup.c", "-x", "none", *for_cortex(contender)]
    said_by(["arm-none-eabi-gcc", *CORTEX, *SMALL, *sources, *options, "-lm", "-o", program])
    shutil.copy(samples, folder / "samples.bin")
    (folder / "rows.txt").write_text(f"{rows}\n")
    (folder / "answers.bin").unlink(missing_ok=True)
    board = ["qemu-system-arm", "-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none"]
    printed = said_by([*board, "-semihosting-config", "enable=on,target=native", "-kernel", program], cwd=folder)
    memory, stack = map(int, printed.split())
    return read_answers(folder / "answers.bin", rows), memory, stack


def replay_here(contender: Contender, samples: Path, rows: int) -> np.ndarray:
    """The same on this machine: attitudes (rows, 4)."""
    program, answers = WORK / "replay", WORK / "answers.bin"
    said_by(["c++", "-O2", "-x", "c", HERE / "replay.c", "-x", "none", *parts(contender, ("cc", "c++"), ("-O2",), False), "-lm",
         "-o", program])  # fmt: skip
    said_by([program, samples, str(rows), answers])
    return read_answers(answers, rows)


def largest_angle_deg(a: np.ndarray, b: np.ndarray) -> float:
    """Between attitudes row by row."""
    return float(np.degrees(np.linalg.norm(rotation_error_rad(a, b), axis=1)).max())


def table_of(samples: Path, rows: int) -> Table:
    table = titled_table("", "filter | scalar", "code, kB | memory, kB | stack, kB | beside this machine, deg")
    for contender in CONTENDERS:
        there, memory, stack = replay_in_qemu(contender, samples, rows)
        here = replay_here(Contender(contender.label, "float" if contender.label == "Fusion" else "double", contender.own,
                                     contender.peer), samples, rows)  # fmt: skip
        sizes = (f"{size / 1024:.1f}" for size in (code_bytes(contender), memory, stack))
        table.add_row(contender.label, contender.scalar, *sizes, f"{largest_angle_deg(there, here):.1g}")
    return table


def command(seconds: Annotated[float, typer.Option(min=1, max=69, help="Of the recording")] = SECONDS) -> None:
    """Code, memory and stack on a Cortex-M4F, and the answers there beside those of double precision here."""
    if missing := missing_tools():
        raise UsageError(f"this machine has no {', '.join(missing)}: see docs/embedded.md for the packages")
    WORK.mkdir(parents=True, exist_ok=True)
    rows = min(ROWS, int(seconds * 286))
    write_samples(WORK / "recording.bin", rows)
    show(table_of(WORK / "recording.bin", rows))
    say("code: a program that only filters, with all that it calls of libm and libgcc; memory: of one filter")
