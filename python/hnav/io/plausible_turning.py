"""Checks whether units, axes and signs of a recording agree, by the rotation of field and force against the rates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from hnav.io.findings import Finding, Samples, unit_name, warning
from hnav.io.plausible_rates import unit_of_rates
from hnav.io.recordings import Recording
from hnav.io.turning import Fit, Stay, axes_text, best_fit, fit_of, fixed_axes, stay_of
from hnav.units import si_per

SCALE = (0.6, 1.6)  # of the rate, by the turning of the field; beyond it something is wrong
SCALE_ERROR = (0.03, 2.0)
"""Of that scale at correlation r, a and b: at most a + b (1 - r^2). Chosen: 14 recorded hands and 22 simulated bodies have at most half of it."""
SCALE_BY_FORCE = (0.4, 2.5)  # accelerations turn it too; ranges of a chip differ by 2, 4 and 8
DEGREES = (40.0, 80.0)  # tolerance of the ratio 57.3, which means degrees read as radians
SURE, BETTER_BY = 0.8, 0.25  # correlations
DIP_RAD = np.radians(10)  # below this the dip does not distinguish up from down
DIP_SPREAD = 0.5  # spread of sin(dip) between quartiles: above it the field is disturbed
HELD = 0.97  # share of gravity that stays constant after the rotation is removed, if the rates are right
NAMES = {"gyro": "rate", "accel": "force", "mag": "field"}


def findings_by_turning(recording: Recording, live: Samples, found: list[Finding], hemisphere: str | None) -> Iterator[Finding]:
    """Findings about units and axes by the rotation of field and force, and about signs by the dip."""
    codes = {(finding.sensor, finding.code): finding for finding in found}
    time = codes.get(("time", "unit"))
    factor = _factor_of_times(recording, time)
    gravity_gone = ("accel", "gravity_removed") in codes
    usable = {sensor for sensor in ("mag", "accel") if sensor in live and "gyro" in live} - ({"accel"} if gravity_gone else set())
    fits = {
        sensor: fit_of(live["gyro"], live[sensor], factor, offset=sensor == "mag") if sensor in usable else None
        for sensor in ("mag", "accel")
    }
    if time is not None and not time.argument:
        return
    stay = stay_of(live["gyro"], live["accel"], factor) if "accel" in usable else None
    yield from _scale(recording, _without_sway(fits, stay), codes)
    if not _turns_as_the_rates_say(fits, stay):
        yield from _unit_of_rates(recording, live, codes, factor)
    wrong = _wrong_axes(fits, stay)
    used = ("mag", "unit") not in codes  # a field with a wrong unit fails whatever its axes
    yield from (replace(finding, certain=used or wrong != "mag") for finding in _axes(live, fits, stay, wrong, hemisphere))
    if not wrong:
        yield from _sign(live, codes, hemisphere, gravity_gone)


def _factor_of_times(recording: Recording, unit: Finding | None) -> float:
    """Factor from the assumed time unit to the unit that fits."""
    return si_per("time", unit.value) / si_per("time", unit_name(recording, "time")) if unit and unit.argument else 1.0


def _turns_as_the_rates_say(fits: Mapping[str, Fit | None], stay: Stay | None) -> bool:
    follows = any(fit is not None and fit.as_it_is >= SURE for fit in fits.values())
    return follows or bool(stay and stay.decides and stay.as_it_is > HELD)


def _without_sway(fits: dict[str, Fit | None], stay: Stay | None) -> Mapping[str, Fit | None]:
    """A sensor high above the axis of a sway measures a force that turns several times as far, while gravity stays: a bicycle."""
    return fits | {"accel": None} if stay is not None and stay.as_it_is > HELD else fits


def _scale(recording: Recording, fits: Mapping[str, Fit | None], codes: Mapping[tuple[str, str], Finding]) -> Iterator[Finding]:
    """Rates that are too large or too small for the observed rotation: another unit if one fits, otherwise another scale."""
    sure = {sensor: fit.scale for sensor, fit in fits.items() if fit is not None and fit.as_it_is >= SURE}
    if ("gyro", "unit") in codes:
        return
    taken = unit_name(recording, "gyro")
    for sensor, scale in sure.items():
        for ratio, how, other in ((1 / scale, "fast", "deg/s"), (scale, "slow", "rad/s")):
            if DEGREES[0] < ratio < DEGREES[1] and taken != other:
                shown = f"rates are {ratio:.0f} times too {how} for the turning of the {NAMES[sensor]}: this looks like {other}"
                yield warning("unit", "gyro", shown, "gyro_unit", other, certain=True)
                return
    for sensor, scale in sure.items():
        low, high = SCALE if sensor == "mag" else SCALE_BY_FORCE
        if not low < scale < high:
            yield _wrong_scale(sensor, scale, certain=True)
            return
    field = fits["mag"] if "mag" in sure else None
    if field is not None and abs(field.scale - 1) > SCALE_ERROR[0] + SCALE_ERROR[1] * (1 - field.as_it_is**2):
        yield _wrong_scale("mag", field.scale, certain=False)


def _wrong_scale(sensor: str, scale: float, certain: bool) -> Finding:
    shown = f"the {NAMES[sensor]} turns {scale:.2f} times as fast as the rates say"
    return warning("scale", "gyro", shown, advice="see the scale of the rates, and the times: rate_hz", certain=certain)


def _unit_of_rates(
    recording: Recording, live: Samples, codes: Mapping[tuple[str, str], Finding], factor: float
) -> Iterator[Finding]:
    """Rates that were assumed to be rad/s, if the rotation alone cannot decide."""
    unit = recording.origin.units.get("gyro") if recording.origin else None
    assumed = unit is None or unit.source == "assumed"
    if "gyro" not in live or ("gyro", "unit") in codes or unit_name(recording, "gyro") != "rad/s":
        return
    evidence = unit_of_rates({sensor: one for sensor, one in live.items() if (sensor, "gravity_removed") not in codes}, factor)
    if evidence.unit == "deg/s":
        yield warning("unit", "gyro", f"{evidence.because}: this looks like deg/s", "gyro_unit", "deg/s", certain=assumed)
    elif evidence.unit is None and unit is not None and assumed:
        shown = f"the unit of the gyroscope is unknown: the file does not say it, and nothing decides it ({evidence.because})"
        yield warning("unit", "gyro", shown, advice="say gyro_unit=deg/s or gyro_unit=rad/s", certain=True)


def _wrong_axes(fits: Mapping[str, Fit | None], stay: Stay | None) -> str | None:
    """The sensor whose axes disagree with the others."""
    mag, accel = (fits[sensor] for sensor in ("mag", "accel"))
    force_off = stay is not None and stay.off
    if mag is not None and _fits_otherwise(mag):
        return "gyro" if force_off or best_fit(mag).handed < 0 else "mag"
    if force_off:
        return "accel"
    if accel is None or not _fits_otherwise(accel):
        return None
    # Without a field that turns with the rates, either sensor may be wrong.
    return "accel" if mag is not None and mag.as_it_is >= SURE else "gyro"


def _fits_otherwise(fit: Fit) -> bool:
    best = best_fit(fit)
    return best.correlation >= SURE and best.correlation - fit.as_it_is > BETTER_BY


def _axes(
    live: Samples, fits: Mapping[str, Fit | None], stay: Stay | None, wrong: str | None, hemisphere: str | None
) -> Iterator[Finding]:
    fit = fits["mag"]
    if wrong == "accel" and stay is not None and stay.off:
        matrix = fixed_axes(stay.best.matrix.T, wrong, live, hemisphere)
        shown = f"the axes do not fit: {stay.as_it_is:.2f} of gravity stays when the body turns, with these {stay.best.correlation:.2f}"
        yield warning("axes", wrong, shown, "axes", f"{wrong}={axes_text(matrix)}")
    elif wrong:
        yield from _other_axes(live, fits, wrong, hemisphere)
    else:
        yield from _axes_not_testable(live, fit, stay)


def _axes_not_testable(live: Samples, fit: Fit | None, stay: Stay | None) -> Iterator[Finding]:
    if "accel" in live and "gyro" in live and not (stay and stay.decides):
        yield Finding("note", "not_testable", "accel", "not testable: axes of force and rate, because the body turns too little")
    if "mag" in live and "gyro" in live:
        if fit is None:
            yield Finding("note", "not_testable", "mag", "not testable: axes of field and rate, because the body hardly turns")
        elif fit.as_it_is < SURE:
            shown = f"not testable: axes of field and rate, because the field changes by more than turning (correlation {fit.as_it_is:.2f})"
            yield Finding("note", "not_testable", "mag", shown)


def _other_axes(live: Samples, fits: Mapping[str, Fit | None], wrong: str, hemisphere: str | None) -> Iterator[Finding]:
    """The axes for which field or force turn with the rates."""
    for other in ("mag", "accel"):
        fit = fits[other]
        if fit is None or not _fits_otherwise(fit) or (wrong != "gyro" and other != wrong):
            continue
        best = best_fit(fit)
        matrix = best.matrix if wrong == "gyro" else fixed_axes(best.matrix, wrong, live, hemisphere)
        shown = f"the axes do not fit: {NAMES[other]} and rate turn together with a correlation of {fit.as_it_is:.2f}, with these of {best.correlation:.2f}"
        yield warning("axes", wrong, shown, "axes", f"{wrong}={axes_text(matrix)}")
        return


def _sign(
    live: Samples, codes: Mapping[tuple[str, str], Finding], hemisphere: str | None, gravity_gone: bool
) -> Iterator[Finding]:
    """The signs of force and field: force points up, and north of the magnetic equator the field points down."""
    if "accel" not in live:
        return
    not_testable = "not testable: sign of the force, because "
    if "mag" not in live or gravity_gone:
        reason = "nothing else distinguishes up from down" if "mag" not in live else "gravity was removed"
        yield Finding("note", "not_testable", "accel", not_testable + reason)
        return
    if ("mag", "strength") in codes:
        yield Finding("note", "not_testable", "accel", not_testable + "the field is not that of the Earth")
        return
    sines = dip_sines(live)
    low, middle, high = np.quantile(sines, [0.25, 0.5, 0.75]) if len(sines) else (-1.0, 0.0, 1.0)
    dip_deg = float(np.degrees(np.arcsin(np.clip(middle, -1, 1))))
    if high - low > DIP_SPREAD or abs(middle) < np.sin(DIP_RAD):
        yield Finding("note", "not_testable", "accel", f"{not_testable}the field is level or disturbed (dip {dip_deg:.0f} deg)")
    elif (middle < 0) == (hemisphere != "south"):
        points, side, other = ("up", "south", "south") if middle < 0 else ("down", "north", "north")
        shown = f"the field points {points} by {abs(dip_deg):.0f} deg as the force has it: right only {side} of the magnetic equator, else force or field is negated"
        advice, certain = f'or say hemisphere "{other}"', hemisphere is not None
        yield warning("sign", "accel", shown, "axes", "accel=-x,-y,-z", advice, certain)


def dip_sines(live: Samples) -> np.ndarray:
    """Sine of the field's dip, positive downward, at rows where the body hardly accelerates."""
    (accel_s, force), (mag_s, field) = live["accel"], live["mag"]
    force = force[np.clip(np.searchsorted(accel_s, mag_s), 0, len(accel_s) - 1)]
    lengths, strengths = np.linalg.norm(force, axis=1), np.linalg.norm(field, axis=1)
    quiet = (np.abs(lengths / np.median(lengths) - 1) < 0.15) & (strengths > 0)
    return np.asarray(-(force[quiet] * field[quiet]).sum(axis=1) / (lengths[quiet] * strengths[quiet]))
