"""The filters of hnav live: rows in, the columns of the table of hnav filter and the state of the page out."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hnav.cli.navigation import PAIRED, Outcome, of_navigation, of_run
from hnav.cli.words import UsageError
from hnav.filters.attitude_answers import Run
from hnav.filters.attitude_recording import LibraryRun
from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.filters.ins_answers import PHASES, READY, InsRun
from hnav.filters.ins_recording import NavigationRun, interval_of, paired
from hnav.filters.options import Options
from hnav.filters.run_files import columns
from hnav.io.findings import Finding
from hnav.io.live_lines import AID_COLUMNS
from hnav.io.readers.aids import aids_in
from hnav.io.readers.columns import Column
from hnav.io.recordings import CSV_COLUMNS, Recording
from hnav.native.arrays import Array

AIDING = ("position", "velocity", "pressure", "speed")
AIDS = {name: Column(name, name, place) for place, name in enumerate(AID_COLUMNS)}
Table = Mapping[str, np.ndarray]


class LiveFilter(ABC):
    """A filter over arriving rows."""

    def recording(self, rows: Array) -> Recording:
        """Rows in the format of LiveLines: times, rates, forces, fields."""
        return Recording("live", rows[:, 0].copy(), *(np.ascontiguousarray(rows[:, begin : begin + 3]) for begin in (1, 4, 7)))

    @abstractmethod
    def go_on(self, recording: Recording) -> Table:
        """The columns of the estimates for these rows. Raises HnavError and UsageError."""

    @abstractmethod
    def state(self, table: Table) -> dict[str, Any]:
        """State of the newest row, for the page."""

    def samples(self, recording: Recording) -> dict[str, int]:
        """Sample counts of each sensor whose health is shown."""
        return {sensor: len(recording.samples(sensor)[0]) for sensor in HEALTH_SENSORS}

    def findings(self, found: list[Finding]) -> list[Finding]:
        """Findings that are relevant to the filter."""
        return found

    def warnings(self) -> list[str]:
        """Lines at the end of the session."""
        return []


def live_filter(options: Options) -> LiveFilter:
    """Raises HnavError for impossible options."""
    return _Navigation(options) if options.filter == "ins" else _Attitude(options)


def newest_of(table: Table) -> tuple[dict[str, float], bool]:
    """The newest row, and whether it has an attitude."""
    last = {name: float(values[-1]) for name, values in table.items()}
    return last, math.isfinite(last["q0"])


def shown_of(last: Mapping[str, float], known: bool) -> dict[str, Any]:
    """The values of the newest row that the pages of all filters show."""
    return {"t_s": last["t_s"], "q": [last[f"q{i}"] for i in range(4)] if known else None}


class _Attitude(LiveFilter):
    def __init__(self, options: Options):
        self._library = LibraryRun(options)
        self._run: Run | None = None

    def go_on(self, recording: Recording) -> Table:
        self._run = self._library.go_on(recording)
        return columns(self._run)

    def state(self, table: Table) -> dict[str, Any]:
        assert self._run is not None, "a table comes of a run"
        last, known = newest_of(table)
        return shown_of(last, known) | {
            "frame": self._library.options.navigation_frame, "heading_deg": last["heading_deg"] if known else None,
            "sigma_deg": np.degrees(self._run.sigma_rad[-1]).tolist() if known else None,
            "ready": {"tilt": bool(self._run.ready[-1, 0]), "heading": bool(self._run.ready[-1, 1])},
            "health": {name: SENSOR_STATES[state] for name, state in zip(HEALTH_SENSORS, self._run.health[-1])},
        }  # fmt: skip


class _Navigation(LiveFilter):
    def __init__(self, options: Options):
        self._options, self._summary = options, Outcome()
        self._ran: NavigationRun | None = None
        self._run: InsRun | None = None
        self._seen = {*HEALTH_SENSORS[:2], AIDING[0]}
        """Sensors to show: a sensor that no source has is not reported as missing."""

    def recording(self, rows: Array) -> Recording:
        made = super().recording(rows)
        values = {name: rows[:, len(CSV_COLUMNS) + column.place] for name, column in AIDS.items()}
        return replace(made, aids={kind: one for kind, one in aids_in(AIDS, values, made.t_s).items() if len(one.t_s)})

    def go_on(self, recording: Recording) -> Table:
        if self._ran is None:
            if paired(recording) is not recording:
                raise UsageError(f"--filter ins: {PAIRED}")
            self._ran = NavigationRun(self._options, {}, interval_of(recording))
        self._run = self._ran.go_on(recording)
        self._summary.add(self._run)
        return columns(self._run)

    def state(self, table: Table) -> dict[str, Any]:
        assert self._run is not None and self._ran is not None, "a table comes of a run"
        last, known = newest_of(table)
        health = self._ran.ins.health().sensor
        place = [last[name] for name in ("lat_deg", "lon_deg", "alt_m")]
        return shown_of(last, known) | {
            "frame": "ned", "heading_deg": last["heading"] if known else None,
            "sigma_deg": np.degrees(self._run.sigma_rotation_rad[-1]).tolist() if known else None,
            "ready": {name: bool(last[f"{name}_ready"]) for name in READY},
            "health": {name: health[name].state for name in (*HEALTH_SENSORS, *AIDING) if name in self._seen},
            "phase": PHASES[int(last["phase"])].replace("_", " "),
            "place": [*place, *self._run.sigma_position_m[-1].tolist()] if np.isfinite(place).all() else None,
            "velocity": [last[name] for name in ("vn", "ve", "vd")] if known else None,
        }  # fmt: skip

    def samples(self, recording: Recording) -> dict[str, int]:
        of_aids = {kind: len(recording.aids[kind].t_s) if kind in recording.aids else 0 for kind in AIDING}
        made = super().samples(recording) | of_aids
        self._seen |= {sensor for sensor, n in made.items() if n}
        return made

    def findings(self, found: list[Finding]) -> list[Finding]:
        return of_navigation(found)

    def warnings(self) -> list[str]:
        return [] if self._ran is None else of_run(self._summary, self._ran)
