"""The page and the picture of a run, whichever filter it is of."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hnav.errors import HnavValueError
from hnav.filters.attitude_answers import Run
from hnav.filters.ins_answers import InsRun
from hnav.filters.observer import ObserverRun
from hnav.filters.run_base import RunBase
from hnav.io.recordings import Recording
from hnav.reports.recording_run import recording_run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def report_run(run: RunBase, path: str | Path, recording: Recording | None = None) -> None:
    """Writes one HTML page about a run that needs no network. Needs Plotly. Raises HnavError if it cannot be written.

    recording: what the run was made of; the page then shows its samples, its reference attitude and what is not plausible in it too.
    """
    # Plotly takes a while to load.
    findings = [str(finding) for finding in recording.check()] if recording is not None else []
    if isinstance(run, ObserverRun):
        from hnav.reports.observer_page import report_observer

        report_observer(run, path)
    elif isinstance(run, InsRun):
        from hnav.reports.navigation_page import write_navigation_report

        write_navigation_report(run, path, recording, findings)
    else:
        from hnav.reports.recording_page import write_recording_report

        write_recording_report(recording_run(_attitude(run), recording, findings), Path(path))


def plot_run(run: RunBase, recording: Recording | None = None) -> Figure:
    """The estimate of a run over time in s with its sigma, as a figure of Matplotlib.

    recording: what an attitude filter's run was made of; differences to its reference attitude are drawn, if it has one. Raises
    HnavError when it has other rows.
    """
    # Matplotlib takes a while to load.
    from hnav.reports.estimate_pictures import draw_navigation, draw_observer
    from hnav.reports.recording_picture import draw_recording

    if isinstance(run, ObserverRun):
        return draw_observer(run)
    if isinstance(run, InsRun):
        return draw_navigation(run)
    return draw_recording(recording_run(_attitude(run), recording))


def _attitude(run: RunBase) -> Run:
    if not isinstance(run, Run):
        raise HnavValueError("unsupported", f"{type(run).__name__} has no page and no picture", "run")
    return run
