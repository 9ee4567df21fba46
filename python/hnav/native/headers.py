"""Writes hnav/native/_hnav.py, the C headers for cffi; runs when the package is built, never when it is used.

python python/hnav/native/headers.py --compiler cc --include c_src/include --output python/hnav/native/_hnav.py
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from pathlib import Path

from cffi import FFI

SYSTEM_HEADERS = ("stddef.h", "stdint.h", "stdbool.h")  # cffi has their types


def declarations(include: Path, compiler: str = "cc") -> str:
    """The declarations of the headers in include/hnav, without comments, macros and system headers."""
    headers = [f"-include{header.resolve()}" for header in sorted((include / "hnav").glob("*.h"))]
    with tempfile.TemporaryDirectory() as empty:
        for name in SYSTEM_HEADERS:
            Path(empty, name).touch()
        # -I, because zig searches its own folders before those of -isystem; an empty file, because zig does not read a pipe.
        command = [compiler, "-E", "-P", "-nostdinc", "-I", empty, "-I", str(include), *headers, "-x", "c", "/dev/null"]
        return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout


def write_binding(include: Path, output: Path, compiler: str) -> None:
    """The declarations as a Python module that opens libraries without a parser (cffi, out-of-line ABI mode)."""
    builder = FFI()
    builder.cdef(declarations(include, compiler))
    builder.set_source("hnav.native._hnav", None)
    builder.emit_python_code(str(output))
    output.touch()  # cffi leaves a file with equal content alone; the build expects it to be newer than the headers


def main() -> None:
    """The command line above."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--compiler", default="cc")
    parser.add_argument("--include", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    chosen = parser.parse_args()
    write_binding(chosen.include, chosen.output, chosen.compiler)


if __name__ == "__main__":
    main()
