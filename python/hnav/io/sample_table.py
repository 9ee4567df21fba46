"""Samples of named sensors and inputs as a table of text: a column t_s, an empty cell where there is no sample."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from hnav.errors import HnavValueError

Column = npt.NDArray[np.float64]
TIME = ("t_s", "time", "t")


def read_sample_table(path: Path | str) -> tuple[Column, dict[str, Column]]:
    """Times, and the other columns by name, NaN where a cell is empty. Lines that begin with # are left out.

    Raises HnavValueError that names file, column and row.
    """
    path = Path(path)
    try:
        table = pd.read_csv(path, comment="#", skipinitialspace=True, dtype=str, keep_default_na=False)
    except OSError as error:
        raise HnavValueError("file", f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, pd.errors.ParserError) as error:
        raise HnavValueError("file", f"{path}: no table: {str(error).splitlines()[0]}") from None
    time = next((name for name in TIME if name in table.columns), None)
    if time is None:
        raise HnavValueError(
            "file", f"{path.name} has no column of times: call it t_s; it has {', '.join(map(str, table.columns))}"
        )
    columns = {str(name): _numbers(path, str(name), table[name].tolist()) for name in table.columns}
    t_s = columns.pop(time)
    late = np.flatnonzero(~np.isfinite(t_s) | (np.diff(t_s, prepend=-math.inf) < 0))
    if len(late):
        raise HnavValueError("file", f"{path.name}: times must not run back or be missing, but {time} does in row {late[0] + 1}")
    return t_s, columns


def _numbers(path: Path, name: str, cells: list[str]) -> Column:
    """Number by number, as Python reads them: the bits that were written."""
    numbers = np.full(len(cells), math.nan)
    for row, cell in enumerate(cells):
        if cell.strip():
            try:
                numbers[row] = float(cell)
            except ValueError:
                raise HnavValueError("file", f"{path.name}: {name} is no number in row {row + 1}: {cell}") from None
    return numbers


def sample_table(head: Sequence[str], columns: Mapping[str, Column]) -> str:
    """The text of a table, with lines after # at its head; numbers in full, empty cells for NaN."""
    text = pd.DataFrame(dict(columns)).to_csv(index=False)
    return "".join(f"# {line}\n" for line in head) + str(text)
