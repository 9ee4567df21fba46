"""hnav compare DIR --filter NAME: errors and consistency of a filter on the BROAD trials of a folder."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.table import Table

from hnav.cli.console import say, show, tracked
from hnav.cli.recordings import warn, warnings_of
from hnav.cli.wanted import Wanted
from hnav.fmi.engines import run_recording
from hnav.io.outputs import refuse_overwriting, write_files
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials, is_disturbed
from hnav.reports.scores import Score, nees, score


def compare_trials(folder: Path, wanted: Wanted, crop_s: float | None, json_file: Path | None) -> None:
    """Prints the errors of each trial and their means. crop_s: only so much of each trial. Raises HnavError, UsageError."""
    filter, engine, preset = wanted.filter, wanted.engine, wanted.preset
    chosen = {**wanted.settings, "navigation_frame": "enu"}
    trials = find_trials(folder)
    refuse_overwriting([json_file], trials.values())
    scores: dict[str, Score] = {}
    consistency: dict[str, float] = {}
    us_per_sample = []
    warnings: list[str] = []
    for path in tracked(list(trials.values()), "trials"):
        data = read(path)
        warnings += warnings_of(path, data.check(), wanted.strict)
        if crop_s is not None:
            data = data.cropped(crop_s)
        result = run_recording(data, filter, engine, chosen, preset, smooth=wanted.smooth)
        truth = data.needed("reference_q_nb")
        scores[data.name] = score(result.q_nb, truth, data.movement)
        consistency[data.name] = nees(result.q_nb, result.sigma_rad, truth, data.movement)
        us_per_sample.append(result.us_per_sample)
    warn(warnings)
    show(score_table(scores, consistency, f"{filter} ({engine})"))
    us = float(np.median(us_per_sample))
    say(f"median time per sample: {us:.2f} us")
    if json_file:
        figures = {
            "filter": filter, "engine": engine, "settings": chosen, "preset": preset, "us_per_sample": us,
            "trials": {
                str(number): {"name": name, **scores[name]._asdict(), "nees_per_axis": consistency[name]}
                for number, name in zip(trials, scores, strict=True)
            },
            "mean": mean_score(scores)._asdict(),
        }  # fmt: skip
        write_files({json_file: json.dumps(figures, indent=1) + "\n"})


GROUPS: dict[str, Callable[[str], bool]] = {
    "mean": lambda name: True,
    "undisturbed": lambda name: not is_disturbed(name),
    "disturbed": is_disturbed,
}


def mean_score(scores: dict[str, Score], keep: Callable[[str], bool] = GROUPS["mean"]) -> Score:
    kept = [found for name, found in scores.items() if keep(name)]
    return Score(*np.mean(kept, axis=0).tolist()) if kept else Score(np.nan, np.nan, np.nan)


def score_table(scores: dict[str, Score], consistency: dict[str, float], title: str) -> Table:
    """By name of the trial, and means; RMSE in deg. NEES/3 is from the sigmas, without correlations."""
    table = Table("trial", f"{title}: total", "heading", "inclination", "NEES/3", title="RMSE in deg over the movement phase")

    def cells(*values: float) -> list[str]:
        return ["-" if np.isnan(v) else f"{v:.2f}" for v in values]

    for name, found in scores.items():
        table.add_row(name, *cells(*found, consistency[name]))
    table.add_section()
    for group, keep in GROUPS.items():
        stated = [v for name, v in consistency.items() if keep(name)]
        table.add_row(group, *cells(*mean_score(scores, keep), float(np.mean(stated)) if stated else np.nan))
    return table
