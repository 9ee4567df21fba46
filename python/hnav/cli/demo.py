"""The paper's experiment in closed co-simulation, and an attitude filter's FMU over real recordings.

    python -m hnav.cli.demo [RECORDING] [--part all|experiment|recordings] [--engine fmi3-cs] [--set name=value] [--out DIR]

The experiment: FMUs of turntable, sensors and three filters, stepped by fmpy from their SSP system; a report of one run,
and the paper's Table 1 beside ours. The recordings: two that hold the device's own attitude (see
hnav.io.device_recordings), or the user's own, with the default preset and nothing tuned; how far filter and device are
apart, what the filter says about itself, and one picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NoReturn

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from hnav.errors import HnavError, HnavRuntimeError, HnavValueError
from hnav.filters.rotations import quaternion_product
from hnav.fmi.engines import Result, run_recording
from hnav.io.device_recordings import PACKAGE, VERSION, WheelUnavailable, find_wheel, read_x_imu, read_xsens
from hnav.io.recordings import Recording, RecordingError, read_recording
from hnav.native.library import parse_setting
from hnav.reports import plots

# The start is left out of the comparison: the filter has one sample of each sensor there, the device has its past.
SETTLING_S = 1.0
PARTS = ("all", "experiment", "recordings")
# Rows of the innovation of force and field.
EXPECTED_NIS = {"hrekf": (3, 3), "ahrs": (2, 3)}


@dataclass(frozen=True)
class Run:
    """A recording, what the filter made of it, and where the reference attitude is from ("" if there is none)."""

    recording: Recording
    result: Result
    reference: str
    filter: str


@dataclass(frozen=True)
class Comparison:
    """Differences estimate - reference in deg, after the settling time; series have NaN where there is no reference.

    Total is the angle of the rotation between both; it splits into heading (about the vertical) and inclination
    (about a horizontal axis) as in Laidig et al. 2021, doi 10.3390/data6070072. The heading offset is the circular
    mean of the heading difference: two devices may call different directions north. `heading_deg` is free of it.
    """

    total_deg: np.ndarray
    heading_deg: np.ndarray
    inclination_deg: np.ndarray
    heading_offset_deg: float


def compare(t_s: np.ndarray, q_nb: np.ndarray, reference_q_nb: np.ndarray) -> Comparison:
    """q_nb, reference_q_nb: n x 4, scalar first, body to the same navigation frame."""
    w, x, y, z = quaternion_product(q_nb, reference_q_nb * [1, -1, -1, -1]).T
    used = (t_s - t_s[0] >= SETTLING_S) & np.isfinite(w)
    heading = np.where(used, 2 * np.arctan2(z, w), np.nan)
    offset = np.angle(np.mean(np.exp(1j * heading[used])))
    return Comparison(
        total_deg=np.degrees(np.where(used, 2 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w)), np.nan)),
        heading_deg=np.degrees(np.angle(np.exp(1j * (heading - offset)))),
        inclination_deg=np.degrees(np.where(used, 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)), np.nan)),
        heading_offset_deg=float(np.degrees(offset)),
    )


# --------------------------------------------------------------------------------------------- running


def run_engine(recording: Recording, reference: str, filter: str, engine: str, settings: dict[str, str]) -> Run:
    """The filter over the recording, in east-north-up as the references are.

    Raises HnavError for impossible settings, and when the recording does not let the filter start.
    """
    if "navigation_frame" in settings:
        raise HnavValueError("option", "navigation_frame: the demo works in east-north-up; `hnav filter` has the others")
    with Console(stderr=True).status(f"{recording.name} by {engine}"):
        result = run_recording(recording, filter, engine, settings={**settings, "navigation_frame": "enu"})
    if not np.isfinite(result.q_nb[-1]).all():
        raise HnavRuntimeError(
            "not started", f"{recording.name}: the filter did not start: it needs force and field (or --set start_mode=heading)"
        )
    return Run(recording, result, reference, filter)


# --------------------------------------------------------------------------------------------- printing


def summary(runs: list[Run], settings: dict[str, str]) -> Table:
    """The figures of all runs, one column each."""
    chosen = ["default preset", *(f"{name}={value}" for name, value in settings.items())]
    table = Table(title=f"{runs[0].filter}, engine {runs[0].result.engine}, {', '.join(chosen)}", title_justify="left")
    table.add_column("", no_wrap=True)
    for run in runs:
        table.add_column(run.recording.name, justify="right", no_wrap=True)
    columns = [figures(run) for run in runs]
    for name in columns[0]:
        table.add_row(name, *(column[name] for column in columns))
    return table


def figures(run: Run) -> dict[str, str]:
    """What stands in a column of the table: text by row name."""
    recording, result = run.recording, run.result
    counts = result.counts
    duration_s = recording.t_s[-1] - recording.t_s[0]
    rows = {
        "length, median sample rate": f"{duration_s:.1f} s, {1 / np.median(np.diff(recording.t_s)):.0f} Hz",
        "used rate / force / field": " / ".join(str(counts[f"{sensor}_used"]) for sensor in ("gyro", "accel", "mag")),
        "gated force / field": f"{counts['accel_gated']} / {counts['mag_gated']}",
    }
    if run.reference:
        against = compare(recording.t_s, result.q_nb, recording.reference_q_nb)
        rows |= {
            f"difference to the {run.reference}": "median    RMS    ",
            "  total": _median_rms(against.total_deg),
            "  heading, offset removed": _median_rms(against.heading_deg),
            "  inclination": _median_rms(against.inclination_deg),
            "  constant heading offset": f"{against.heading_offset_deg:+.1f} deg",
        }
    bias, bias_sigma = np.degrees(result.gyro_bias_rad_s[-1]), np.degrees(result.gyro_bias_sigma_rad_s[-1])
    tilt_deg, heading_deg = _tilt_sigma_deg(result)[-1], np.degrees(result.sigma_rad[-1, 2])
    return rows | {
        "the filter about itself": "",
        "  σ tilt, heading at the end": f"{tilt_deg:.1f}, {heading_deg:.1f} deg",
        f"  mean NIS force (expected {EXPECTED_NIS[run.filter][0]})": _mean(result.accel_nis),
        f"  mean NIS field (expected {EXPECTED_NIS[run.filter][1]})": _mean(result.mag_nis),
        "  gyro bias x ± σ": f"{bias[0]:+.2f} ± {bias_sigma[0]:.2f} deg/s",
        "  gyro bias y ± σ": f"{bias[1]:+.2f} ± {bias_sigma[1]:.2f} deg/s",
        "  gyro bias z ± σ": f"{bias[2]:+.2f} ± {bias_sigma[2]:.2f} deg/s",
        "time per row": f"{result.us_per_sample:.1f} µs",
    }


def _median_rms(difference_deg: np.ndarray) -> str:
    size = np.abs(difference_deg[np.isfinite(difference_deg)])
    return f"{np.median(size):6.1f} {np.sqrt(np.mean(size**2)):6.1f} deg"


def _mean(nis: np.ndarray) -> str:
    used = nis[np.isfinite(nis)]
    return f"{used.mean():.2g}" if len(used) else "no samples"


def _tilt_sigma_deg(result: Result) -> np.ndarray:
    """Standard deviation of the inclination: both horizontal axes together."""
    return np.degrees(np.hypot(result.sigma_rad[:, 0], result.sigma_rad[:, 1]))


# --------------------------------------------------------------------------------------------- the picture


def picture(runs: list[Run]) -> plots.Figure:
    """One column a recording: attitude, differences in the filter's own 3 sigma, NIS, gyro bias, over time in s."""
    compared = any(run.reference for run in runs)
    names = ["attitude"] + (["heading", "inclination"] if compared else ["sigma"]) + ["nis", "bias"]
    with plots.styled():
        fig = plots.figure(850 * len(runs), 320 + 230 * len(names))
        grid = fig.subplots(len(names), len(runs), squeeze=False, sharex="col", height_ratios=[1.5] + [1.0] * (len(names) - 1))
        for column, run in enumerate(runs):
            draw_run(dict(zip(names, grid[:, column])), run)
        fig.align_ylabels()
        fig.tight_layout(h_pad=1.2, w_pad=2.0)
    return fig


def draw_run(panels: dict[str, plots.Axes], run: Run) -> None:
    """One column of the picture."""
    recording, result = run.recording, run.result
    t_s = recording.t_s - recording.t_s[0]
    reference_q_nb = recording.reference_q_nb if run.reference else None
    drawn = plots.draw_attitude(panels["attitude"], t_s, result.q_nb, reference_q_nb, run.reference)
    panels["attitude"].set_title(f"{recording.name}\n{drawn}, body to east-north-up")
    if run.reference:
        against = compare(recording.t_s, result.q_nb, reference_q_nb)
        plots.draw_error_band(panels["heading"], t_s, against.heading_deg, np.degrees(result.sigma_rad[:, 2]), "heading")
        panels["heading"].set_title(f"Heading against the {run.reference}")
        plots.draw_error_band(
            panels["inclination"],
            t_s,
            against.inclination_deg,
            _tilt_sigma_deg(result),
            "inclination",
            plots.GREEN,
            one_sided=True,
        )
        panels["inclination"].set_title(f"Inclination against the {run.reference}")
    else:
        plots.draw_sigma(panels["sigma"], t_s, np.degrees(result.sigma_rad), ("east", "north", "up"))
        panels["sigma"].set_title("Standard deviation of the rotation about")
    plots.draw_nis(panels["nis"], t_s, {"force": result.accel_nis, "field": result.mag_nis})
    panels["nis"].set_title("Innovations")
    plots.draw_bias(panels["bias"], t_s, np.degrees(result.gyro_bias_rad_s), np.degrees(result.gyro_bias_sigma_rad_s))
    panels["bias"].set_title("Gyro bias")
    panels["bias"].set_xlabel("time / s")
    panels["bias"].set_xlim(t_s[0], t_s[-1])


# --------------------------------------------------------------------------------------------- the command


app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
console = Console(highlight=False)


def device_runs(filter: str, engine: str, settings: dict[str, str]) -> list[Run]:
    """The two device recordings; prints what is known about each."""
    wheel = find_wheel()
    runs = []
    for found in (read_xsens(wheel), read_x_imu(wheel)):
        console.print(f"[bold]{found.recording.name}[/bold]  {PACKAGE} {VERSION}, {found.source}")
        for finding in found.findings:
            console.print(f"  {finding}")
        runs.append(run_engine(found.recording, "device", filter, engine, settings))
    return runs


def own_run(file: Path, mag_unit: str, filter: str, engine: str, settings: dict[str, str]) -> Run:
    """The user's file, against the optical reference if it holds one."""
    recording = read_recording(file, mag_unit=mag_unit)
    if len(recording.t_s) < 2:
        raise RecordingError(f"{file}: one row is no recording")
    return run_engine(recording, "" if recording.reference_q_nb is None else "optics", filter, engine, settings)


def fail(text: str) -> NoReturn:
    """One line on stderr, exit code 2."""
    typer.echo(f"demo: {text}", err=True)
    raise typer.Exit(2)


def show_experiment(out: Path, runs: int) -> None:
    """The turntable in closed co-simulation: one run with its report, then Table 1. Raises HnavError."""
    from hnav.reports.page import write_report
    from hnav.systems.simulation import simulate, write_run
    from studies.table1 import SYSTEM, run_table

    console.print(
        "[bold]the paper's experiment[/bold]  FMUs of turntable, sensors and three filters in closed co-simulation, yaw to and fro by 60 deg",
        soft_wrap=True,
    )
    with Console(stderr=True).status("60 s at 100 Hz"):
        run = simulate(SYSTEM, seed=1)
    folder = out / SYSTEM
    write_run(run, folder)
    write_report(run, folder / "report.html")
    console.print(f"  {len(run.t_s)} points of {len(run.columns)} signals in {sum(run.about['wall_s'].values()):.1f} s")
    console.print(f"  report: {folder / 'report.html'}", soft_wrap=True)
    run_table(runs, console)
    console.print(
        "`python -m studies.table1` takes 200 runs; models/systems/turntable/README.md says what was fitted.\n", soft_wrap=True
    )


@app.command()
def demo(
    recording: Annotated[
        Path | None, typer.Argument(help="CSV or BROAD file; without it the experiment and two recordings of devices")
    ] = None,
    part: Annotated[str, typer.Option(help="all, experiment or recordings")] = "all",
    runs: Annotated[int, typer.Option(min=2, help="seeds for Table 1")] = 20,
    filter: Annotated[str, typer.Option(help="hrekf or ahrs")] = "hrekf",
    engine: Annotated[str, typer.Option(help="c, fmi3-cs, fmi3-me, fmi2-cs or fmi2-me")] = "fmi3-cs",
    settings: Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="filter option")] = None,
    mag_unit: Annotated[str, typer.Option(help="unit of the field in a CSV file: T, uT, G or au")] = "T",
    out: Annotated[Path, typer.Option(help="folder for the picture")] = Path("demo_out"),
) -> None:
    """The paper's experiment in closed co-simulation, and a filter's FMU over real recordings, with figures and pictures."""
    if part not in PARTS:
        fail(f"--part {part}: choose one of {', '.join(PARTS)}")
    try:
        if recording is None and part != "recordings":
            show_experiment(out, runs)
        if recording is None and part == "experiment":
            return
        chosen = dict(parse_setting(text) for text in settings or [])
        runs = [own_run(recording, mag_unit, filter, engine, chosen)] if recording else device_runs(filter, engine, chosen)
    except (WheelUnavailable, HnavError, RecordingError) as error:
        fail(str(error))
    console.print()
    console.print(summary(runs, chosen))
    for note in notes(runs):
        console.print(note)
    file = out / "demo.png"
    try:
        plots.save(picture(runs), file)
    except OSError as error:
        fail(f"{file}: cannot be written: {error.strerror}")
    console.print(f"picture: {file}")


def notes(runs: list[Run]) -> list[str]:
    """How to read the table."""
    device = "The device's attitude is an estimate too, no ground truth; both recordings are magnetically disturbed."
    nis = (
        "NIS has the expected mean when the noise is as parametrised; the default preset leaves room for accelerations and "
        "disturbed fields, so quiet recordings lie below."
    )
    return [device, nis] if any(run.reference == "device" for run in runs) else [nis]


if __name__ == "__main__":
    app()
