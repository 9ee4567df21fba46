"""MATLAB files, read by SciPy in a process of its own.

SciPy's reader is not hardened: some damaged files crash the process that reads them (scipy/scipy#25349).
The caller's process survives.
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hnav.places import PACKAGE


def read_mat(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The named variables that are in the file, without dimensions of length one; without names all of them, those in structs
    by their path. Raises ValueError with the reason."""
    found_here = os.pathsep.join([str(PACKAGE.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    reader = subprocess.run(
        [sys.executable, "-m", "hnav.io.mat_file", str(path), *names],
        capture_output=True, env=os.environ | {"PYTHONPATH": found_here},
    )  # fmt: skip
    if reader.returncode:
        said = reader.stderr.decode(errors="replace").strip().splitlines()
        raise ValueError(said[-1] if reader.returncode == 1 and said else "the file is damaged: SciPy's reader crashed over it")
    with np.load(io.BytesIO(reader.stdout)) as contents:
        return dict(contents)


def main(path: str, names: list[str]) -> None:
    """Writes what read_mat returns to standard output, as .npz."""
    import scipy.io

    try:
        contents = scipy.io.loadmat(path, variable_names=names or None, squeeze_me=True, simplify_cells=not names)
    except Exception as error:  # SciPy raises errors of any type for a damaged file
        sys.exit(" ".join(str(error).split()) or type(error).__name__)
    buffer = io.BytesIO()
    found = {name: contents[name] for name in names if name in contents} if names else dict(arrays_in(contents, ""))
    np.savez(buffer, **found)
    sys.stdout.buffer.write(buffer.getvalue())


def arrays_in(tree: Mapping[str, Any], before: str) -> Iterator[tuple[str, np.ndarray]]:
    """Flattens nested structs into arrays and texts."""
    for name, value in tree.items():
        if isinstance(value, Mapping):
            yield from arrays_in(value, f"{before}{name}_")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and not str(name).startswith("__"):
            yield f"{before}{name}", value
        elif isinstance(value, str) and not str(name).startswith("__"):
            yield f"{before}{name}", np.asarray(value)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
