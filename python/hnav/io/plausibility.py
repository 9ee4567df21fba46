"""Whether a recording can be what it is taken for: units, axes, signs, gaps, sensors that do not work.

    for finding in recording.check(): print(finding)

A warning names what was found, the number, and the cure; an error is a recording that no filter can use; a note says what the
data cannot tell, and why. What turning tells stands in hnav.io.turning. Nothing here changes a recording.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from hnav.errors import HnavValueError
from hnav.io.recordings import ARRAYS, Recording
from hnav.io.turning import Fit, Stay, axes_text, best_fit, fit_of, fixed_axes, stay_of
from hnav.units import G_M_S2, SI_PER

LEVELS = ("error", "warning", "note")
HEMISPHERES = ("north", "south")

FORCE_M_S2 = (7.8, 12.5)  # median of a body that moves; 9.8 at rest
LEAST_COUNTS = 500.0  # of gravity, in a chip of 16 g and 16 bits 2048
GRAVITY_GONE_M_S2 = 3.0
FIELD_TESLA = (15e-6, 120e-6)  # the Earth's 22 to 67 uT, with room for hard iron
EARTH_TESLA = (18e-6, 80e-6)  # where another unit would put it
HARD_IRON_TESLA = 1e-3  # no hard iron of a device is as large
INTERVAL_S = (1e-4, 0.25)  # between samples
USUAL_INTERVAL_S = (4e-4, 0.11)
FASTEST_RAD_S = 50.0  # no gyroscope of a body reads more for a thousandth of the time
GAP_S = 1.0  # and ten usual intervals
SCALE = (0.6, 1.6)  # of the rate, by the turning of the field
DEGREES = (40.0, 80.0)  # of that scale, where 57.3 says that degrees were taken for radians
SURE, BETTER_BY = 0.8, 0.25  # correlations
DIP_RAD = np.radians(10)  # below this the dip does not tell up from down
DIP_SPREAD = 0.5  # of sin(dip), quartile to quartile: above, it is no dip
CLIPPED_FROM = {"gyro": 1.7, "accel": 1.5 * G_M_S2, "mag": 200e-6}  # no sensor ends below
NOTHING = "see whether its columns are the right ones; leave out a magnetometer that was off"
RANGES = {"gyro": "gyro_range_rad_s", "accel": "accel_range_m_s2", "mag": "mag_range_tesla"}
CLIPPED_BAND, CLIPPED_SAMPLES = 0.05, 8
REPEATED_ROWS, REPEATED_FIELDS, ZERO_SHARE = 0.2, 0.6, 0.01
ENOUGH = 50  # samples to judge by
NAMES = {"gyro": "rate", "accel": "force", "mag": "field"}
UNIT_NAMES = {"gyro": "rad/s", "accel": "m/s2", "mag": "T"}


@dataclass(frozen=True)
class Finding:
    """Something about a recording that is wrong, doubtful, or cannot be known."""

    level: str
    """error, warning or note."""
    code: str
    """no_samples, all_zero, constant, unit, gravity_removed, strength, scale, axes, sign, gaps, saturated, repeated, absent or
    not_testable."""
    sensor: str
    """gyro, accel, mag or time; position or velocity of what aids navigation."""
    message: str
    """What was found, with its number."""
    argument: str | None = None
    """The argument of hnav.read, or of check, that mends it."""
    value: str = ""
    """Its value."""
    advice: str = ""
    """What else may be done."""

    @property
    def cure(self) -> str:
        """What to do, in Python's words."""
        sensor, _, axes = self.value.partition("=")
        value = "True" if self.value == "yes" else f'{{"{sensor}": "{axes}"}}' if axes else f'"{self.value}"'
        return "; ".join(filter(None, [f"use {self.argument}={value}" if self.argument else "", self.advice]))

    def __str__(self) -> str:
        return f"{self.level}: {self.sensor}: {self.message}" + (f"; {self.cure}" if self.cure else "")


def check(recording: Recording, hemisphere: str | None = None) -> list[Finding]:
    """What is not plausible in a recording, the worst first. hemisphere: "north" or "south" of the magnetic equator, if it is
    known; without it, north is taken. Raises HnavError for another hemisphere.
    """
    if hemisphere not in (None, *HEMISPHERES):
        raise HnavValueError("option", f"hemisphere = {hemisphere}: choose one of {', '.join(HEMISPHERES)}", "hemisphere")
    samples = {sensor: recording.samples(sensor) for sensor in ARRAYS}
    found = [*_working(recording, samples)]
    dead = {finding.sensor for finding in found if finding.code in ("no_samples", "all_zero", "absent")}
    live = {sensor: kept for sensor, kept in samples.items() if sensor not in dead and len(kept[0]) >= ENOUGH}
    found += _time(recording, live)
    found += _gaps(live)
    found += _strengths(recording, live)
    found += _clipped(live)
    found += _repeated(recording, live)
    found += _turning(recording, live, found, hemisphere)
    return sorted(found, key=lambda finding: LEVELS.index(finding.level))


def _warning(code: str, sensor: str, message: str, argument: str | None = None, value: str = "", advice: str = "") -> Finding:
    return Finding("warning", code, sensor, message, argument, value, advice)


Samples = Mapping[str, tuple[np.ndarray, np.ndarray]]

# --------------------------------------------------------------------------------------------- sensors that do not work


def _working(recording: Recording, samples: Samples) -> Iterator[Finding]:
    """Sensors without samples, zero, or stuck for the whole time."""
    for sensor, (t_s, values) in samples.items():
        n = len(t_s)
        if n == 0 and getattr(recording, ARRAYS[sensor]) is None:
            yield Finding("note", "absent", sensor, "there is no magnetometer: heading counts from the start, and drifts")
        elif n == 0:
            yield Finding("error", "no_samples", sensor, f"none of {len(recording.t_s)} rows has a sample", advice=NOTHING)
        elif not values.any():
            # A body at rest has no rate; without gravity, or without a field that is said to be there, nothing can be done.
            level = "warning" if sensor == "gyro" else "error"
            yield Finding(level, "all_zero", sensor, f"all {n} samples are zero", advice=NOTHING)
        elif n >= ENOUGH:
            yield from _stuck(sensor, values)


def _stuck(sensor: str, values: np.ndarray) -> Iterator[Finding]:
    same = values.max(axis=0) == values.min(axis=0)
    unit = UNIT_NAMES[sensor]
    if same.all():
        shown = ", ".join(f"{v:.4g}" for v in values[0])
        yield _warning(
            "constant", sensor, f"all {len(values)} samples are ({shown}) {unit}", advice="look at the sensor and its driver"
        )
        return
    for axis in np.flatnonzero(same):
        shown = f"axis {'xyz'[axis]} is {values[0, axis]:.4g} {unit} in all {len(values)} samples"
        yield _warning("constant", sensor, shown, advice="look at the sensor, its driver and the column")
    zero = ~values.any(axis=1)
    if sensor != "gyro" and zero.mean() > ZERO_SHARE:
        shown = f"{100 * zero.mean():.0f} % of the samples are zero vectors"
        yield _warning("constant", sensor, shown, advice="leave the cells of missing samples empty")


# --------------------------------------------------------------------------------------------- units


def _unit_name(recording: Recording, quantity: str) -> str:
    """The unit that the numbers of the file were taken for."""
    unit = recording.origin.units.get(quantity) if recording.origin else None
    return unit.name if unit else next(iter(SI_PER[quantity]))


def _other_unit(recording: Recording, quantity: str, value: float, low: float, high: float) -> str | None:
    """The unit in which a median, given in SI, would lie between low and high."""
    taken = _unit_name(recording, quantity)
    number = value / SI_PER[quantity][taken]
    fitting = [name for name, factor in SI_PER[quantity].items() if name not in (taken, "au") and low <= number * factor <= high]
    middle = np.sqrt(low * high)
    return min(fitting, key=lambda name: abs(np.log(number * SI_PER[quantity][name] / middle)), default=None)


def _time(recording: Recording, live: Samples) -> Iterator[Finding]:
    for sensor in ("gyro", "accel"):
        if sensor in live:
            interval_s = float(np.median(np.diff(live[sensor][0])))
            break
    else:
        return
    if INTERVAL_S[0] <= interval_s <= INTERVAL_S[1]:
        return
    shown = f"the median interval is {interval_s:.4g} s"
    if unit := _other_unit(recording, "time", interval_s, *USUAL_INTERVAL_S):
        yield _warning("unit", "time", f"{shown}: this looks like {unit}", "time_unit", unit)
    elif interval_s > INTERVAL_S[1]:
        yield _warning(
            "unit", "time", f"{shown}: too long to follow a motion", advice="record at 20 Hz or more, or say the time_unit"
        )
    else:
        yield _warning("unit", "time", f"{shown}: no sensor is as fast", advice="say the time_unit or the rate_hz")


def _strengths(recording: Recording, live: Samples) -> Iterator[Finding]:
    if _are_counts(recording, live):
        yield _warning(
            "unit",
            "accel",
            "gyro and accel are whole numbers, and large: these look like counts of the chip",
            advice="multiply by the scales of its ranges, often 1/131 deg/s and 1/16384 g",
        )
        return
    if "accel" in live:
        yield from _force(recording, np.linalg.norm(live["accel"][1], axis=1))
    if "mag" in live and _unit_name(recording, "mag") != "au":
        yield from _field(recording, float(np.median(np.linalg.norm(live["mag"][1], axis=1))))
    if "gyro" in live:
        fastest = float(np.quantile(np.abs(live["gyro"][1]).max(axis=1), 0.999))
        if fastest > FASTEST_RAD_S:
            shown = f"rates of {fastest:.0f} rad/s are more than a gyroscope reads"
            unit = {"rad/s": "deg/s", "deg/s": "mdeg/s"}.get(_unit_name(recording, "gyro"))
            yield _warning("unit", "gyro", f"{shown}: this looks like {unit}", "gyro_unit", str(unit))


def _are_counts(recording: Recording, live: Samples) -> bool:
    """Whether a chip's numbers were written as they came: whole, and of no unit."""
    if not {"gyro", "accel"} <= live.keys():
        return False
    strength = float(np.median(np.linalg.norm(live["accel"][1], axis=1)))
    if strength < LEAST_COUNTS or _other_unit(recording, "accel", strength, *FORCE_M_S2):
        return False
    return all((live[sensor][1] == np.round(live[sensor][1])).all() for sensor in ("gyro", "accel"))


def _force(recording: Recording, lengths: np.ndarray) -> Iterator[Finding]:
    median, low = float(np.median(lengths)), float(np.quantile(lengths, 0.1))
    if FORCE_M_S2[0] <= median <= FORCE_M_S2[1]:
        return
    shown = f"median |force| {median:.3g} m/s2"
    unit = _other_unit(recording, "accel", median, *FORCE_M_S2)
    if unit and low > 0.5 * median:
        yield _warning("unit", "accel", f"{shown}: this looks like {unit}", "accel_unit", unit)
    elif median < GRAVITY_GONE_M_S2:
        yield _warning(
            "gravity_removed",
            "accel",
            f"{shown}, where a body at rest has 9.8: gravity was removed",
            advice="record the whole force: TotalAcceleration or AccelerometerUncalibrated, not linear or user acceleration",
        )
    else:
        yield _warning(
            "unit",
            "accel",
            f"{shown}, where a body at rest has 9.8",
            advice="see the unit, accel_unit, and the range that the driver sets",
        )


def _field(recording: Recording, median: float) -> Iterator[Finding]:
    if FIELD_TESLA[0] <= median <= FIELD_TESLA[1]:
        return
    shown = f"median |field| {1e6 * median:.4g} uT"
    unit_read = recording.origin.units.get("mag") if recording.origin else None
    stated = unit_read is not None and unit_read.source != "assumed"
    hard_iron = stated and FIELD_TESLA[1] < median < HARD_IRON_TESLA  # which milligauss, taken for microtesla, are too
    if not hard_iron and (unit := _other_unit(recording, "mag", median, *EARTH_TESLA)):
        yield _warning("unit", "mag", f"{shown}: this looks like {unit}", "mag_unit", unit)
    elif 0.75 <= median / SI_PER["mag"][_unit_name(recording, "mag")] <= 1.6:
        yield _warning("unit", "mag", f"{shown}: this looks like an arbitrary unit", "mag_unit", "au")
    else:
        yield _warning(
            "strength", "mag", f"{shown}, the Earth's is 22 to 67 uT", advice="hnav calibrate finds hard iron; or see mag_unit"
        )


# --------------------------------------------------------------------------------------------- samples


def _gaps(live: Samples) -> Iterator[Finding]:
    for sensor, (t_s, _) in live.items():
        steps_s = np.diff(t_s)
        gaps = steps_s > max(GAP_S, 10 * float(np.median(steps_s)))
        if gaps.any():
            longest = int(np.argmax(steps_s))
            count = "a gap" if gaps.sum() == 1 else f"{gaps.sum()} gaps, the longest"
            yield _warning(
                "gaps",
                sensor,
                f"{count} of {steps_s[longest]:.2f} s at {t_s[longest]:.10g} s",
                advice="what happened there is not known; look at the logger",
            )


def _clipped(live: Samples) -> Iterator[Finding]:
    """Axes whose samples pile up at the largest value that they have."""
    for sensor, (_, values) in live.items():
        ends = [(axis, *at_end) for axis, column in zip("xyz", values.T) for at_end in _piled_up(column, CLIPPED_FROM[sensor])]
        if ends:
            axes = "".join(dict.fromkeys(axis for axis, _, _ in ends))
            size = min(size for _, size, _ in ends)
            shown = (
                f"{sum(n for _, _, n in ends)} samples of {axes} stand at {size:.4g} {UNIT_NAMES[sensor]}: the end of the range"
            )
            advice = f"tell the filter by {RANGES[sensor]}={0.99 * size:.4g}, or use a wider range"
            yield _warning("saturated", sensor, shown, advice=advice)


def _piled_up(column: np.ndarray, smallest: float) -> Iterator[tuple[float, int]]:
    """Size and number of the samples at an end, where they are more than those just below it."""
    for end in (float(column.max()), float(column.min())):
        at_end = int(np.count_nonzero(column == end))
        beside = int(np.count_nonzero(np.abs(column - end) < CLIPPED_BAND * abs(end))) - at_end
        if abs(end) >= smallest and max(CLIPPED_SAMPLES, beside) <= at_end < len(column):
            yield abs(end), at_end


def _repeated(recording: Recording, live: Samples) -> Iterator[Finding]:
    if "gyro" in live and "accel" in live:
        both = np.hstack([recording.rate_b_rad_s, recording.force_b_m_s2])
        both = both[~np.isnan(both).any(axis=1)]
        repeats = (both[1:] == both[:-1]).all(axis=1)
        if len(both) >= ENOUGH and both.std(axis=0).any() and repeats.mean() > REPEATED_ROWS:
            shown = f"{100 * repeats.mean():.0f} % of the rows repeat the one before"
            yield _warning("repeated", "gyro", f"{shown}: they were written more often than measured", "drop_repeats", "yes")
    if "mag" in live:
        t_s, field = live["mag"]
        repeats = (field[1:] == field[:-1]).all(axis=1)
        if REPEATED_FIELDS < repeats.mean() < 1:
            rate_hz = (1 - repeats.mean()) / float(np.median(np.diff(t_s)))
            shown = f"{100 * repeats.mean():.0f} % of the samples repeat the one before: it measures at {rate_hz:.3g} Hz, and repeats count as news"
            yield _warning("repeated", "mag", shown, "drop_repeats", "yes")


def check_aids(recording: Recording) -> list[Finding]:
    """What is not plausible in what aids navigation, which attitude filters do not read."""
    found = []
    for kind in ("position", "velocity"):
        if (one := recording.aids.get(kind)) is not None and len(one.t_s) >= max(ENOUGH, 0.5 * len(recording.t_s)):
            share = 1 - len(one.without_repeats().t_s) / len(one.t_s)
            if share > REPEATED_FIELDS:
                shown = f"{100 * share:.0f} % of the rows repeat the fix before: each would count as a new one"
                found.append(_warning("repeated", kind, shown, "drop_repeats", "yes"))
    return found


# --------------------------------------------------------------------------------------------- turning


def _turning(recording: Recording, live: Samples, found: list[Finding], hemisphere: str | None) -> Iterator[Finding]:
    """What the turning of field and force tells of units and axes, and the dip of signs."""
    codes = {(finding.sensor, finding.code): finding for finding in found}
    time = codes.get(("time", "unit"))
    factor = SI_PER["time"][time.value] / SI_PER["time"][_unit_name(recording, "time")] if time and time.argument else 1.0
    gravity_gone = ("accel", "gravity_removed") in codes
    fits: dict[str, Fit | None] = {}
    for sensor in ("mag", "accel"):
        usable = "gyro" in live and sensor in live and not (sensor == "accel" and gravity_gone)
        fits[sensor] = fit_of(live["gyro"], live[sensor], factor, offset=sensor == "mag") if usable else None
    if time is not None and not time.argument:
        return
    yield from _scale(recording, fits, codes)
    stay = stay_of(live["gyro"], live["accel"], factor) if "gyro" in live and "accel" in live and not gravity_gone else None
    wrong = _wrong_axes(fits, stay)
    yield from _axes(live, fits, stay, wrong, hemisphere)
    if not wrong:
        yield from _sign(live, codes, hemisphere, gravity_gone)


def _scale(recording: Recording, fits: Mapping[str, Fit | None], codes: Mapping[tuple[str, str], Finding]) -> Iterator[Finding]:
    """Rates that are too fast or slow for what turns."""
    if ("gyro", "unit") in codes:
        return
    for sensor, fit in fits.items():
        if fit is None or fit.as_it_is < SURE:
            continue
        too_fast, word = 1 / fit.scale, NAMES[sensor]
        taken = _unit_name(recording, "gyro")
        for ratio, other in ((too_fast, "deg/s"), (1 / too_fast, "rad/s")):
            if DEGREES[0] < ratio < DEGREES[1] and taken != other:
                how = "fast" if other == "deg/s" else "slow"
                yield _warning(
                    "unit",
                    "gyro",
                    f"rates are {ratio:.0f} times too {how} for the turning of the {word}: this looks like {other}",
                    "gyro_unit",
                    other,
                )
                return
        if sensor == "mag" and not SCALE[0] < fit.scale < SCALE[1]:
            yield _warning(
                "scale",
                "gyro",
                f"the field turns {fit.scale:.2f} times as fast as the rates say",
                advice="see the scale of the rates, and the times: rate_hz",
            )


def _wrong_axes(fits: Mapping[str, Fit | None], stay: Stay | None) -> str | None:
    """The sensor whose axes do not fit the others."""
    mag, accel = (fits[sensor] for sensor in ("mag", "accel"))
    force_off = stay is not None and stay.off
    if mag is not None and _fits_otherwise(mag):
        return "gyro" if force_off or best_fit(mag).handed < 0 else "mag"
    if force_off:
        return "accel"
    if accel is None or not _fits_otherwise(accel):
        return None
    # With no field that turns as the rates say, either may be wrong.
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
        yield _warning("axes", wrong, shown, "axes", f"{wrong}={axes_text(matrix)}")
    elif wrong:
        yield from _other_axes(live, fits, wrong, hemisphere)
    else:
        yield from _axes_not_testable(live, fit, stay)


def _axes_not_testable(live: Samples, fit: Fit | None, stay: Stay | None) -> Iterator[Finding]:
    if "accel" in live and "gyro" in live and not (stay and stay.tells):
        yield Finding("note", "not_testable", "accel", "not testable: axes of force and rate, because the body turns too little")
    if "mag" in live and "gyro" in live:
        if fit is None:
            yield Finding("note", "not_testable", "mag", "not testable: axes of field and rate, because the body hardly turns")
        elif fit.as_it_is < SURE:
            shown = f"not testable: axes of field and rate, because the field changes by more than turning (correlation {fit.as_it_is:.2f})"
            yield Finding("note", "not_testable", "mag", shown)


def _other_axes(live: Samples, fits: Mapping[str, Fit | None], wrong: str, hemisphere: str | None) -> Iterator[Finding]:
    """The axes with which field or force turn as the rates say."""
    for other in ("mag", "accel"):
        fit = fits[other]
        if fit is None or not _fits_otherwise(fit) or (wrong != "gyro" and other != wrong):
            continue
        best = best_fit(fit)
        matrix = best.matrix if wrong == "gyro" else fixed_axes(best.matrix, wrong, live, hemisphere)
        shown = f"the axes do not fit: {NAMES[other]} and rate turn together with a correlation of {fit.as_it_is:.2f}, with these of {best.correlation:.2f}"
        yield _warning("axes", wrong, shown, "axes", f"{wrong}={axes_text(matrix)}")
        return


def _sign(
    live: Samples, codes: Mapping[tuple[str, str], Finding], hemisphere: str | None, gravity_gone: bool
) -> Iterator[Finding]:
    """Force points up, and north of the magnetic equator the field down."""
    if "accel" not in live:
        return
    not_testable = "not testable: sign of the force, because "
    if "mag" not in live or gravity_gone:
        reason = "nothing else tells up from down" if "mag" not in live else "gravity was removed"
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
        yield _warning("sign", "accel", shown, "axes", "accel=-x,-y,-z", advice=f'or say hemisphere "{other}"')


def dip_sines(live: Samples) -> np.ndarray:
    """Sine of the field's dip, positive downward, where the force is that of a body that hardly accelerates."""
    (accel_s, force), (mag_s, field) = live["accel"], live["mag"]
    nearest = np.clip(np.searchsorted(accel_s, mag_s), 0, len(accel_s) - 1)
    force = force[nearest]
    lengths, strengths = np.linalg.norm(force, axis=1), np.linalg.norm(field, axis=1)
    quiet = (np.abs(lengths / np.median(lengths) - 1) < 0.15) & (strengths > 0)
    return np.asarray(-(force[quiet] * field[quiet]).sum(axis=1) / (lengths[quiet] * strengths[quiet]))
