"""Panels of the report about attitude filters: angles, errors, biases, fields, innovations, consistency, gates, times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hnav.reports.angles import euler_deg, near_turn
from hnav.reports.colours import FAINT, INK, SKY
from hnav.reports.graphs import go, make_subplots
from hnav.reports.panels import band, blocks, colour_of, dots, grid_of, line, panel, small, span, translucent
from hnav.rotations import euler_rad
from hnav.systems.results import Run
from hnav.systems.run_views import (
    SENSORS,
    STATES,
    TRUTH_FIELD,
    Estimate,
    estimates,
    magnetometer,
    measured_field,
    truth_component,
    truth_q_nb,
)
from hnav.systems.statistics import chi_square_interval

AXES = ("north", "east", "down")
SHOWN_SHARE = 0.998  # share of the errors within the axis
START_S = 1.0  # as hnav.reports.recording_run settles
SETTLING_SHARE = 0.1  # share of the run that does not scale an axis: the initial error may be any size
PROBABILITY = 0.95
MICROTESLA = 1e6
NORMALISED_FLOOR = 1e-8  # lower end of the axis of normalised squares: without noise they are arbitrarily small


def has_filters(run: Run) -> bool:
    return bool(estimates(run))


def has_errors(run: Run) -> bool:
    return has_filters(run) and truth_component(run) is not None


def _titles(filters: list[Estimate]) -> list[str] | None:
    """Of columns; one column needs none."""
    return [estimate.name for estimate in filters] if len(filters) > 1 else None


def _settled(run: Run) -> np.ndarray:
    """Rows after the start."""
    return np.asarray(run.t_s >= run.t_s[0] + SETTLING_SHARE * (run.t_s[-1] - run.t_s[0]))


def truth_name(run: Run) -> str:
    """Name of the attitude with which the estimates are compared."""
    return str(run.about.get("truth", "truth"))


def _shown_deg(run: Run, q_nb: np.ndarray) -> np.ndarray:
    """Roll, pitch and heading; an angle from east, counter-clockwise, is turned into a heading."""
    angles = euler_deg(q_nb)
    if run.about.get("frame") == "enu":
        angles[:, 2] = 90 - angles[:, 2]
    # The first heading is shown between 0 and 360 deg; whole turns have no meaning.
    known = np.flatnonzero(np.isfinite(angles[:, 2]))
    if len(known):
        angles[:, 2] -= 360 * np.floor(angles[known[0], 2] / 360)
    return angles


def _angle_sigma_deg(estimate: Estimate) -> np.ndarray:
    """Standard deviations of roll, pitch and heading from those about the navigation axes, without their correlations."""
    sigma, angles = np.degrees(estimate.vector("att.sigma", 3)), euler_rad(estimate.q_nb)
    cosine, sine = np.cos(angles[:, 2]), np.sin(angles[:, 2])
    pitch = np.hypot(sine * sigma[:, 0], cosine * sigma[:, 1])
    roll = np.hypot(cosine * sigma[:, 0], sine * sigma[:, 1]) / np.maximum(np.cos(angles[:, 1]), 0.1)
    return np.stack([roll, pitch, sigma[:, 2]], axis=1)


@panel("attitude", "Attitude and heading", "Roll, pitch and heading, rotation order z y x, in their bands of ±3σ; dashed what they are "
       "compared with. Whole turns add up: 450 deg is 90 deg. Near a pitch of 90 deg roll and heading say little.", has_filters)  # fmt: skip
def attitude_panel(run: Run) -> go.Figure:
    figure = grid_of(3, 1)
    truth = truth_q_nb(run)
    angles = None if truth is None else _shown_deg(run, truth)
    settled = _settled(run)
    held: list[np.ndarray] = [] if angles is None else [angles]
    for estimate in estimates(run):
        shown, around = _shown_deg(run, estimate.q_nb), 3 * _angle_sigma_deg(estimate)
        # Each is unwrapped by itself and may be whole turns away from the other.
        shown = shown if angles is None else near_turn(shown, angles)
        colour = colour_of(run, estimate.name)
        width = np.nanmedian(around[settled], axis=0) if np.isfinite(around[settled]).any() else np.zeros(3)
        held += [shown[settled] - width, shown[settled] + width, shown[run.t_s >= run.t_s[0] + START_S]]
        for axis in range(3):
            values, width = shown[:, axis], np.minimum(around[:, axis], 180)
            around_it = band(run.t_s, values - width, values + width, colour, f"{estimate.name} ±3σ", axis == 0)
            figure.add_trace(around_it, axis + 1, 1)
            figure.add_trace(line(run.t_s, values, colour, estimate.name, axis == 0), axis + 1, 1)
    for axis, name in enumerate(("roll", "pitch", "heading")):
        if angles is not None:
            dashed = line(run.t_s, angles[:, axis], INK, truth_name(run), axis == 0, dash="dash", width=1.1)
            figure.add_trace(dashed, axis + 1, 1)
        shown_range = span([values[:, axis] for values in held])
        figure.update_yaxes(title_text=f"{name} / deg", range=shown_range, row=axis + 1)
    return figure


@panel("error", "Attitude error", "Rotation from estimate to truth or reference about the navigation axes, inside ±3σ as the filter states it. The scale is that "
       "of the errors: a band that starts wider is cut off.", has_errors)  # fmt: skip
def error_panel(run: Run) -> go.Figure:
    filters = estimates(run)
    figure = grid_of(3, len(filters), _titles(filters), shared_yaxes="rows")
    for axis, name in enumerate(run.about.get("axes", AXES)):
        widest, narrowest = 0.0, np.inf
        for column, estimate in enumerate(filters, start=1):
            colour = colour_of(run, estimate.name)
            error, sigma = estimate.error_deg[:, axis], np.degrees(estimate.vector("att.sigma", 3)[:, axis])
            around = band(run.t_s, -3 * sigma, 3 * sigma, colour, f"{estimate.name} ±3σ", axis == 0)
            figure.add_trace(around, axis + 1, column)
            figure.add_trace(line(run.t_s, error, colour, estimate.name, axis == 0), axis + 1, column)
            # The first row may have any error: a start without a heading is wrong by up to half a turn.
            if np.isfinite(error).any():
                widest = max(widest, np.nanquantile(np.abs(error), SHOWN_SHARE))
            narrowest = min(narrowest, 3 * np.nanmin(sigma, initial=np.inf))
        # The axis includes at least the narrowest band: errors far inside it would otherwise look like zero.
        widest = max(widest, 1.5 * narrowest if np.isfinite(narrowest) else 0.0)
        figure.update_yaxes(range=[-1.15 * widest, 1.15 * widest] if widest else None, row=axis + 1)
        figure.update_yaxes(title_text=f"{name} / deg", row=axis + 1, col=1)
    return figure


@panel("bias", "Gyro bias", "Estimated bias in body axes with its band of ±1σ. The scale is that after the start.", has_filters)
def bias_panel(run: Run) -> go.Figure:
    figure, settled = grid_of(3, 1), _settled(run)
    held: list[np.ndarray] = []
    for estimate in estimates(run):
        colour = colour_of(run, estimate.name)
        bias, sigma = (np.degrees(estimate.vector(f"bias.{name}", 3)) for name in ("gyro", "gyro_sigma"))
        held += [(bias - sigma)[settled], (bias + sigma)[settled]]
        for axis in range(3):
            low, high = bias[:, axis] - sigma[:, axis], bias[:, axis] + sigma[:, axis]
            figure.add_trace(band(run.t_s, low, high, colour, f"{estimate.name} ±1σ", axis == 0), axis + 1, 1)
            figure.add_trace(line(run.t_s, bias[:, axis], colour, estimate.name, axis == 0), axis + 1, 1)
    for axis, name in enumerate("xyz"):
        shown_range = span([values[:, axis] for values in held])
        figure.update_yaxes(title_text=f"{name} / (deg/s)", range=shown_range, row=axis + 1)
    return figure


def _field_strength(run: Run, samples: np.ndarray) -> tuple[float, str]:
    """In microtesla: of the truth, or the median of the samples."""
    truth = truth_component(run)
    if truth is not None and run.has(truth, *(f"{TRUTH_FIELD}[{i}]" for i in (1, 2, 3))):
        return float(MICROTESLA * np.median(np.linalg.norm(run.vector(truth, TRUTH_FIELD, 3), axis=1))), "true"
    return float(np.median(np.linalg.norm(samples, axis=1))), "median"


@panel("field", "Measured field", "Samples of the magnetometer in its own axes, coloured by time, and the circle or sphere of the true strength: iron "
       "moves the points off the centre (hard) or stretches them (soft).", lambda run: magnetometer(run) is not None and bool(estimates(run)))  # fmt: skip
def field_panel(run: Run) -> go.Figure:
    samples = MICROTESLA * measured_field(run)
    samples = samples[np.isfinite(samples).all(axis=1)]
    samples = small(samples[blocks(len(samples))])
    strength, whose = _field_strength(run, samples)
    name = f"{whose} strength, {strength:.1f} µT"
    figure = make_subplots(1, 3, horizontal_spacing=0.08)
    turn = np.linspace(0, 2 * np.pi, 181)
    for column, (i, j) in enumerate(((0, 1), (0, 2), (1, 2)), start=1):
        # Seen along an axis the sphere is a circle.
        figure.add_trace(go.Scatter(x=strength * np.cos(turn), y=strength * np.sin(turn), mode="lines", name=name, showlegend=column == 1,
                                    line=dict(color=FAINT, width=1, dash="dash"), hoverinfo="skip"), 1, column)  # fmt: skip
        figure.add_trace(go.Scatter(x=samples[:, i], y=samples[:, j], mode="markers", name="samples", showlegend=False,
                                    marker=dict(color=small(np.linspace(run.t_s[0], run.t_s[-1], len(samples))), colorscale=[[0, SKY], [1, INK]], size=3.5,
                                                colorbar=dict(title="t / s", thickness=10, len=0.9) if column == 3 else None)), 1, column)  # fmt: skip
        figure.update_xaxes(title_text=f"{'xyz'[i]} / µT", row=1, col=column, constrain="domain")
        figure.update_yaxes(title_text=f"{'xyz'[j]} / µT", row=1, col=column, scaleanchor=f"x{column if column > 1 else ''}")
    figure.update_layout(height=400)
    return figure


@panel("innovations", "Innovations", "Measured minus expected at each sample, inside ±2√S with the noise as parametrised: of a consistent filter 95 % "
       "lie inside. Wider bands are cut off.", lambda run: has_filters(run) and all(run.has(e.name, "innov.accel[1]", "innov.accel_sigma[1]") for e in estimates(run)))  # fmt: skip
def innovations_panel(run: Run) -> go.Figure:
    filters = estimates(run)
    kinds = [(s, meaning, i) for s, meaning in SENSORS.items() for i in range(max(e.dimension(s) for e in filters))]
    figure = grid_of(len(kinds), len(filters), _titles(filters), row_px=125)
    for row, (sensor, meaning, i) in enumerate(kinds, start=1):
        for column, estimate in enumerate(filters, start=1):
            if i >= estimate.dimension(sensor):
                continue
            at = estimate.sampled(sensor)
            colour, t_s = colour_of(run, estimate.name), run.t_s[at]
            value, sigma = (run[f"{estimate.name}.innov.{sensor}{suffix}[{i + 1}]"][at] for suffix in ("", "_sigma"))
            figure.add_trace(band(t_s, -2 * sigma, 2 * sigma, FAINT, "±2√S", row == 1 and column == 1), row, column)
            figure.add_trace(dots(t_s, value, colour, estimate.name, row == 1), row, column)
            if len(at):
                top = 1.15 * max(np.quantile(np.abs(value), SHOWN_SHARE), 2 * np.median(sigma))
                figure.update_yaxes(range=[-top, top] if top > 0 else None, row=row, col=column)
        figure.update_yaxes(title_text=f"{meaning} {i + 1}", row=row, col=1)
    return figure


# Times, values, and the degrees of freedom of each value.
Normalised = tuple[np.ndarray, np.ndarray, int]


def _draw_normalised(run: Run, names: list[str], series: Callable[[Estimate, str], Normalised]) -> go.Figure:
    """Normalised squares on a logarithmic axis with the two-sided chi-square interval and the expectation."""
    filters = estimates(run)
    figure = grid_of(len(names), len(filters), _titles(filters), shared_yaxes="rows")
    floor, top = 1e-2, 1e2
    for row, name in enumerate(names, start=1):
        for column, estimate in enumerate(filters, start=1):
            t_s, values, dimension = series(estimate, name)
            low, high = chi_square_interval(dimension, PROBABILITY)
            ends = run.t_s[[0, -1]]
            first = row == 1 and column == 1
            figure.add_trace(band(ends, np.full(2, low), np.full(2, high), FAINT, f"{PROBABILITY:.0%} of χ²", first), row, column)
            expected = np.full(2, float(dimension))
            figure.add_trace(line(ends, expected, INK, "expectation", first, dash="dash", width=1), row, column)
            shown = np.isfinite(values) & (values > 0)
            if shown.any():
                floor, top = min(floor, np.quantile(values[shown], 0.02)), max(top, 2 * np.quantile(values[shown], SHOWN_SHARE))
            figure.add_trace(dots(t_s[shown], values[shown], colour_of(run, estimate.name), estimate.name, row == 1), row, column)
        figure.update_yaxes(title_text=name, row=row, col=1)
    shown_range = np.log10([max(floor, NORMALISED_FLOOR), top]).tolist()
    figure.update_yaxes(type="log", range=shown_range, exponentformat="power", dtick=2)
    return figure


@panel("nis", "Normalised innovations squared", "One dot a sample; of a filter whose noise is as parametrised 95 % lie in the grey "
       "band.", has_filters)  # fmt: skip
def nis_panel(run: Run) -> go.Figure:
    sensors = {f"NIS {meaning}": sensor for sensor, meaning in SENSORS.items()}

    def series(estimate: Estimate, name: str) -> Normalised:
        rows = estimate.sampled(sensors[name])
        return run.t_s[rows], run[f"{estimate.name}.nis.{sensors[name]}"][rows], estimate.dimension(sensors[name])

    return _draw_normalised(run, list(sensors), series)


@panel("nees", "Normalised estimation error squared", "Attitude error in the filter's own covariance, at every communication point. Neighbours are "
       "correlated: one run wanders, the mean of many runs has the narrow bounds.",
       lambda run: has_errors(run) and all(e.nees is not None for e in estimates(run)))  # fmt: skip
def nees_panel(run: Run) -> go.Figure:
    def series(estimate: Estimate, name: str) -> Normalised:
        assert estimate.nees is not None, "the panel applies where all are known"
        return run.t_s, estimate.nees, 3

    return _draw_normalised(run, ["NEES"], series)


def _gamma_filters(run: Run) -> list[Estimate]:
    with_gamma = [e for e in estimates(run) if run.has(e.name, "hinf.gamma_used", "hinf.margin")]
    return [e for e in with_gamma if run[f"{e.name}.hinf.gamma_used"].any()]


@panel("gamma", "γ and its margin", "γ of each correction and the feasibility 1 − λmax(L P Lᵀ)/γ²; filters with γ off are left out.",
       lambda run: bool(_gamma_filters(run)))  # fmt: skip
def gamma_panel(run: Run) -> go.Figure:
    figure = grid_of(2, 1)
    for estimate in _gamma_filters(run):
        colour, gamma = colour_of(run, estimate.name), run[f"{estimate.name}.hinf.gamma_used"]
        used = gamma > 0
        figure.add_trace(line(run.t_s[used], gamma[used], colour, estimate.name, True), 1, 1)
        figure.add_trace(line(run.t_s[used], run[f"{estimate.name}.hinf.margin"][used], colour, estimate.name, False), 2, 1)
    figure.update_yaxes(title_text="γ", type="log", dtick=1, exponentformat="power", row=1)
    figure.update_yaxes(title_text="margin", range=[-0.03, 1.03], row=2)
    return figure


@panel("states", "Gates and ready states", "Filled: true. A gate that closes for a single sample shows as a gap.", has_filters)
def states_panel(run: Run) -> go.Figure:
    filters = estimates(run)
    # The minimum of each block, so that decimation hides no closed gate. The last row is drawn first, at the bottom.
    starts = blocks(len(run.t_s))
    rows = [
        (f"{e.name}  {text}", np.minimum.reduceat(run[f"{e.name}.{state}"], starts), colour_of(run, e.name))
        for e in filters[::-1] for state, text in reversed(STATES.items()) if run.has(e.name, state)
    ]  # fmt: skip
    figure = go.Figure()
    for level, (name, values, colour) in enumerate(rows):
        # Where it changes says all.
        turns = np.union1d(np.flatnonzero(np.diff(values > 0.5)) + 1, [0, len(starts) - 1])
        top, at_s = small(np.where(values[turns] > 0.5, 0.72, 0.0) + level), small(run.t_s[starts[turns]])
        figure.add_trace(go.Scatter(x=at_s[[0, -1]], y=np.full(2, float(level)), mode="lines", line=dict(width=0),
                                    showlegend=False, hoverinfo="skip"))  # fmt: skip
        figure.add_trace(go.Scatter(x=at_s, y=top, mode="lines", name=name, showlegend=False, fill="tonexty", fillcolor=translucent(colour, 0.45),
                                    line=dict(color=colour, width=0.6, shape="hv"), hovertemplate="%{x:.2f} s"))  # fmt: skip
    ticks = dict(tickvals=np.arange(len(rows)) + 0.36, ticktext=[name for name, _, _ in rows])
    figure.update_yaxes(ticks, range=[-0.3, len(rows)], showgrid=False, zeroline=False)
    figure.update_xaxes(title_text="time / s")
    figure.update_layout(height=90 + 26 * len(rows))
    return figure


@panel("timing", "Time per component", "Wall time of a communication step inside each FMU, calls of the master included.",
       lambda run: bool(run.about["wall_s"]))  # fmt: skip
def timing_panel(run: Run) -> go.Figure:
    names, steps = list(run.about["wall_s"]), max(1, len(run.t_s) - 1)
    filters = {e.name for e in estimates(run)}
    us = [1e6 * run.about["wall_s"][name] / steps for name in names]
    colours = [colour_of(run, name) if name in filters else FAINT for name in names]
    beside = dict(text=[f"{value:.1f}" for value in us], textposition="outside", cliponaxis=False)
    figure = go.Figure(go.Bar(x=us, y=names, orientation="h", marker_color=colours, **beside))
    figure.update_xaxes(title_text="µs per step", range=[0, 1.2 * max(us)])  # with room for the text of the longest bar
    figure.update_yaxes(autorange="reversed")
    figure.update_layout(height=110 + 34 * len(names))
    return figure


ATTITUDE_PANELS = (
    attitude_panel, error_panel, bias_panel, field_panel, innovations_panel, nis_panel, nees_panel, gamma_panel, states_panel,
)  # fmt: skip
