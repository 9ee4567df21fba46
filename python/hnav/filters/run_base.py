"""The run of every filter: arrays with one row for each instant, with its plot, report and table."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from hnav.errors import HnavValueError
from hnav.native.arrays import Array

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd
    from matplotlib.figure import Figure

    from hnav.io.recordings import Recording


class RunBase:
    """Arrays of a run over n instants t_s. In a notebook it shows its figures; plot() draws it, report(path) makes the page of it."""

    t_s: Array
    """n: the instants."""

    def columns(self) -> dict[str, np.ndarray]:
        """The columns of the table by name, each n long."""
        raise NotImplementedError

    def in_one_line(self) -> str:
        """Rows, length, last estimate, what was ready."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.in_one_line()}>"

    def size_in_words(self) -> str:
        """Rows and length."""
        return f"{len(self.t_s)} rows in {self.t_s[-1] - self.t_s[0] if len(self.t_s) else 0:.6g} s"

    def to_dataframe(self) -> pd.DataFrame:
        """The run as a table of pandas, indexed by t_s: a column for each component, its unit at the end of its name."""
        import pandas as pd

        return pd.DataFrame(self.columns(), index=pd.Index(self.t_s, name="t_s"))

    def plot(self, recording: Recording | None = None) -> Figure:
        """The estimate over time with its sigma, as a figure of Matplotlib: savefig, or look at it in a notebook.

        recording: what the run was made of; what it has beside the samples, as a reference attitude, is drawn too.
        """
        import hnav  # what draws stands above the filters; hnav itself imports both

        return hnav.plot_run(self, recording)

    def report(self, path: str | Path, recording: Recording | None = None) -> None:
        """Writes one HTML page that needs no network. Needs Plotly. Raises HnavError if the file cannot be written.

        recording: what the run was made of; the page then shows more of it.
        """
        import hnav  # as in plot

        if not isinstance(path, (str, os.PathLike)):
            raise HnavValueError("option", f"path is no file but a {type(path).__name__}: write report(path, recording)", "path")
        hnav.report_run(self, path, recording)
