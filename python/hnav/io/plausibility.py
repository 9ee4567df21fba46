"""Whether a recording can be what it is taken for: units, axes, signs, gaps, sensors that do not work.

    for finding in recording.check(): print(finding)

A warning names what was found, the number, and the cure; an error is a recording that no filter can use; a note says what the
data cannot show, and why. Checks that need rotation are in hnav.io.plausible_turning. No check changes a recording.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError, PlausibilityWarning
from hnav.io.findings import Finding, Samples, unit_name, warning
from hnav.io.plausible_turning import findings_by_turning
from hnav.io.readers.clock import DAMAGED, MENDED, ORDERED
from hnav.io.recordings import ARRAYS, Recording
from hnav.numbers import floats
from hnav.units import G_M_S2, SUSPECTED, si_per

LEVELS = ("error", "warning", "note")
HEMISPHERES = ("north", "south")
MAGNETIC_EQUATOR_RAD = np.radians(20)  # the magnetic equator is within 15 deg of the geographic one (WMM2025)

FORCE_M_S2 = (7.8, 12.5)  # median specific force of a moving body, m/s2; 9.8 at rest
LEAST_COUNTS = 500.0  # of gravity, in a chip of 16 g and 16 bits 2048
GRAVITY_GONE_M_S2 = 3.0
LARGEST_FORCE_RATIO = 2.0  # of a median to gravity: an aircraft or a centrifuge may have this much, a range set wrong by 2 more
FIELD_TESLA = (15e-6, 120e-6)  # the Earth's 22 to 67 uT, with room for hard iron
EARTH_TESLA = (18e-6, 80e-6)  # where another unit would put it
HARD_IRON_TESLA = 1e-3  # no hard iron of a device is as large
INTERVAL_S = (1e-4, 0.25)  # between samples
USUAL_INTERVAL_S = (4e-4, 0.11)
FASTEST_RAD_S = 50.0  # no gyroscope of a body reads more for a thousandth of the time
GAP_S = 0.3  # and ten usual intervals: a hand turns by a right angle in that time
ENDS_EARLY, ENDS_EARLY_S = 0.2, 1.0  # share and seconds at the end of the recording without samples of a sensor
CLIPPED_FROM = {"gyro": 1.7, "accel": 1.5 * G_M_S2, "mag": 200e-6}  # no sensor has a smaller range
RIGHT_COLUMNS = "see whether its columns are the right ones"
NOTHING = {"gyro": RIGHT_COLUMNS, "accel": RIGHT_COLUMNS, "mag": f"{RIGHT_COLUMNS}; leave out a magnetometer that was off"}
SAY_COUNTS = (
    "say what one count is, often gyro_unit='1/131 deg/s' and accel_unit='1/16384 g' (ranges of 250 deg/s and 2 g), "
    "or gyro_unit='1/16.4 deg/s' and accel_unit='1/2048 g' (2000 deg/s and 16 g)"
)
RANGES = {"gyro": "gyro_range_rad_s", "accel": "accel_range_m_s2", "mag": "mag_range_tesla"}
FEWEST_STILL, STILL_M_S2 = 6, 0.1  # parts of ENOUGH samples in which a body rests, and the spread of the force in them
USUAL_ERROR_M_S2, LARGEST_ERROR_M_S2 = 0.1, 1.5  # of an accelerometer: that filters assume by default, and of the worst
CLIPPED_BAND, CLIPPED_SAMPLES = 0.05, 8
REPEATED_ROWS, REPEATED_FIELDS, ZERO_SHARE = 0.2, 0.6, 0.01
ENOUGH = 50  # samples that a check needs
WILD, WILD_SHARE = 10.0, 0.99  # a field is wild so many times beyond what this share of the samples reaches, as in a calibration
FEWEST_ROWS = 10  # in which something may get ready
NOTED = {
    MENDED: ("clock", "time", "look at the logger; rate_hz puts samples at equal intervals"),
    ORDERED: ("clock", "time", "right if the stamps are times of measurement; a column received_s is for those of arrival"),
    DAMAGED: ("damaged", "file", "copy the log again from the card, and look at the logger"),
}
"""By the beginning of the reader's note: code, sensor and advice of the warning that it is."""
STANDING_STAMPS = 0.5  # share of stamps that may equal the one before
WARNED_ROWS = 5000  # of arrays: 18 ms, whatever their length
ARRAYS_OF_THE_SOUTH = "multiply the force by -1; south of the magnetic equator it is right, and check=False silences this"
UNIT_NAMES = {"gyro": "rad/s", "accel": "m/s2", "mag": "T"}


def check(recording: Recording, hemisphere: str | None = None) -> list[Finding]:
    """Implausible properties of a recording, the worst first. hemisphere: "north" or "south" of the magnetic equator, if
    known; without it, north is assumed. Raises HnavError for another hemisphere."""
    if hemisphere not in (None, *HEMISPHERES):
        raise HnavValueError("option", f"hemisphere = {hemisphere}: choose one of {', '.join(HEMISPHERES)}", "hemisphere")
    samples = {sensor: recording.samples(sensor) for sensor in ARRAYS}
    found = [*_working(recording, samples)]
    dead = {finding.sensor for finding in found if finding.code in ("no_samples", "all_zero", "absent")}
    live = {sensor: kept for sensor, kept in samples.items() if sensor not in dead and len(kept[0]) >= ENOUGH}
    if "mag" in live:
        live["mag"], wild = _without_wild(*live["mag"])
        found += wild
    found += _noted(recording)
    found += _length(recording)
    found += _time(recording, live)
    found += _gaps(recording, live)
    found += _strengths(recording, live)
    found += _accelerometer(live)
    found += _clipped(live)
    found += _repeated(recording, live)
    if hemisphere is None and "position" in recording.aids:
        hemisphere = hemisphere_at(float(np.median(recording.aids["position"].values[:, 0])))
    found += findings_by_turning(recording, live, found, hemisphere)
    return sorted(found, key=lambda finding: LEVELS.index(finding.level))


def _without_wild(t_s: np.ndarray, field: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], list[Finding]]:
    """The samples without those that no field explains, which a fit would follow, and a note about these."""
    off = np.linalg.norm(field - np.median(field, axis=0), axis=1)
    wild = off > WILD * max(float(np.quantile(off, WILD_SHARE)), float(np.median(np.linalg.norm(field, axis=1))))
    if not wild.any():
        return (t_s, field), []
    first = int(np.argmax(wild))
    count = "a sample is" if wild.sum() == 1 else f"{wild.sum()} samples are"
    shown = f"{count} more than {WILD:.0f} times as far off as others, first at {t_s[first]:.10g} s: the checks leave them out"
    return (t_s[~wild], field[~wild]), [
        Finding("note", "outliers", "mag", shown, advice="look at the driver: such are overflows of a chip")
    ]


def _noted(recording: Recording) -> Iterator[Finding]:
    """What the reader has noted and the user must hear of."""
    for note in recording.origin.notes if recording.origin else ():
        for beginning, (code, sensor, advice) in NOTED.items():
            if note.startswith(beginning):
                yield warning(code, sensor, note.removeprefix(beginning), advice=advice)


def _length(recording: Recording) -> Iterator[Finding]:
    if 0 < len(recording.t_s) < FEWEST_ROWS:
        count = "one row" if len(recording.t_s) == 1 else f"{len(recording.t_s)} rows"
        yield warning(
            "short", "time", f"{count} alone: nothing can be checked, and no estimate gets ready", advice="see the file's end"
        )


def hemisphere_at(latitude_rad: float) -> str | None:
    """The side of the magnetic equator; None near it, where the dip of the field is small."""
    return None if abs(latitude_rad) < MAGNETIC_EQUATOR_RAD else "north" if latitude_rad > 0 else "south"


# --------------------------------------------------------------------------------------------- sensors that do not work


def _working(recording: Recording, samples: Samples) -> Iterator[Finding]:
    """Sensors without samples, zero, or stuck for the whole time."""
    for sensor, (t_s, values) in samples.items():
        n = len(t_s)
        if n == 0 and getattr(recording, ARRAYS[sensor]) is None:
            yield Finding("note", "absent", sensor, "there is no magnetometer: heading counts from the start, and drifts")
        elif n == 0:
            level = "warning" if sensor == "mag" else "error"
            shown = f"none of {len(recording.t_s)} rows has a sample"
            yield Finding(level, "no_samples", sensor, shown, advice=NOTHING[sensor], certain=True)
        elif not values.any():
            # A body at rest has no rate, and without a field the heading has a large sigma; without gravity there is no attitude.
            level = "error" if sensor == "accel" else "warning"
            yield Finding(level, "all_zero", sensor, f"all {n} samples are zero", advice=NOTHING[sensor], certain=True)
        elif n >= ENOUGH:
            yield from _stuck(sensor, values)


def _stuck(sensor: str, values: np.ndarray) -> Iterator[Finding]:
    same = values.max(axis=0) == values.min(axis=0)
    unit = UNIT_NAMES[sensor]
    if same.all():
        shown = ", ".join(f"{v:.4g}" for v in values[0])
        yield warning(
            "constant", sensor, f"all {len(values)} samples are ({shown}) {unit}", advice="look at the sensor and its driver"
        )
        return
    for axis in np.flatnonzero(same):
        shown = f"axis {'xyz'[axis]} is {values[0, axis]:.4g} {unit} in all {len(values)} samples"
        yield warning("constant", sensor, shown, advice="look at the sensor, its driver and the column")
    zero = ~values.any(axis=1)
    if sensor != "gyro" and zero.mean() > ZERO_SHARE:
        shown = f"{100 * zero.mean():.0f} % of the samples are zero vectors"
        yield warning("constant", sensor, shown, advice="leave the cells of missing samples empty")


# --------------------------------------------------------------------------------------------- units


def _other_unit(recording: Recording, quantity: str, value: float, low: float, high: float) -> str | None:
    """The unit in which a median, given in SI, would lie between low and high."""
    taken = unit_name(recording, quantity)
    number = value / si_per(quantity, taken)
    suspected = {name: si_per(quantity, name) for name in SUSPECTED[quantity] if name != taken}
    fitting = [name for name, factor in suspected.items() if low <= number * factor <= high]
    middle = np.sqrt(low * high)
    return min(fitting, key=lambda name: abs(np.log(number * suspected[name] / middle)), default=None)


def _time(recording: Recording, live: Samples) -> Iterator[Finding]:
    sensor = next((sensor for sensor in ("gyro", "accel") if sensor in live), None)
    if sensor is None:
        return
    interval_s = float(np.median(np.diff(live[sensor][0])))
    if INTERVAL_S[0] <= interval_s <= INTERVAL_S[1]:
        return
    shown = f"the median interval is {interval_s:.4g} s"
    if unit := _other_unit(recording, "time", interval_s, *USUAL_INTERVAL_S):
        yield warning("unit", "time", f"{shown}: this looks like {unit}", "time_unit", unit, certain=True)
    elif interval_s > INTERVAL_S[1]:
        advice = "record at 20 Hz or more, or say the time_unit"
        yield warning("unit", "time", f"{shown}: too long to follow a motion", advice=advice)
    else:
        yield warning("unit", "time", f"{shown}: no sensor is as fast", advice="say the time_unit or the rate_hz", certain=True)


def _strengths(recording: Recording, live: Samples) -> Iterator[Finding]:
    if _are_counts(recording, live):
        shown = "gyro and accel are whole numbers, and large: these look like counts of the chip"
        yield warning("unit", "accel", shown, advice=SAY_COUNTS, certain=True)
        return
    if _are_swapped(live):
        shown = "the rates have the length of gravity, and the force has not: they look exchanged"
        advice = "give the rates as gx, gy, gz (columns gx=NAME), the force as ax, ay, az"
        yield warning("unit", "gyro", shown, advice=advice, certain=True)
        return
    if "accel" in live:
        yield from _force(recording, np.linalg.norm(live["accel"][1], axis=1))
    if "mag" in live and unit_name(recording, "mag") != "au":
        yield from _field(recording, float(np.median(np.linalg.norm(live["mag"][1], axis=1))))
    if "gyro" in live:
        fastest = float(np.quantile(np.abs(live["gyro"][1]).max(axis=1), 0.999))
        if fastest > FASTEST_RAD_S:
            shown = f"rates of {fastest:.0f} rad/s are more than a gyroscope reads"
            unit = {"rad/s": "deg/s", "deg/s": "mdeg/s"}.get(unit_name(recording, "gyro"))
            yield warning("unit", "gyro", f"{shown}: this looks like {unit}", "gyro_unit", str(unit), certain=True)


def _are_counts(recording: Recording, live: Samples) -> bool:
    """Whether the samples are raw counts of a chip: whole numbers without a unit."""
    if not {"gyro", "accel"} <= live.keys():
        return False
    strength = float(np.median(np.linalg.norm(live["accel"][1], axis=1)))
    if strength < LEAST_COUNTS or _other_unit(recording, "accel", strength, *FORCE_M_S2):
        return False
    return all((live[sensor][1] == np.round(live[sensor][1])).all() for sensor in ("gyro", "accel"))


def _are_swapped(live: Samples) -> bool:
    """Whether the rates have the magnitude of gravity, and vary less than the force, whose median is smaller: swapped sensors."""
    if not {"gyro", "accel"} <= live.keys():
        return False
    rates, forces = (np.quantile(np.linalg.norm(live[sensor][1], axis=1), [0.1, 0.5, 0.9]) for sensor in ("gyro", "accel"))
    varies, force_varies = ((high - low) / max(middle, 1e-9) for low, middle, high in (rates, forces))
    return bool(forces[1] < FORCE_M_S2[0] < rates[1] < FORCE_M_S2[1] and varies < force_varies)


def _force(recording: Recording, lengths: np.ndarray) -> Iterator[Finding]:
    median, low = float(np.median(lengths)), float(np.quantile(lengths, 0.1))
    if FORCE_M_S2[0] <= median <= FORCE_M_S2[1]:
        return
    shown = f"median |force| {median:.3g} m/s2"
    unit = _other_unit(recording, "accel", median, *FORCE_M_S2)
    if unit and low > 0.5 * median:
        yield warning("unit", "accel", f"{shown}: this looks like {unit}", "accel_unit", unit, certain=True)
    elif median < GRAVITY_GONE_M_S2:
        shown += ", where a body at rest has 9.8: gravity was removed"
        advice = "record the whole force: TotalAcceleration or AccelerometerUncalibrated, not linear or user acceleration"
        yield warning("gravity_removed", "accel", shown, advice=advice, certain=True)
    else:
        advice = "see the unit, accel_unit, and the range that the driver sets"
        certain = abs(np.log(median / G_M_S2)) > np.log(LARGEST_FORCE_RATIO)
        yield warning("unit", "accel", f"{shown}, where a body at rest has 9.8", advice=advice, certain=certain)


def _accelerometer(live: Samples) -> Iterator[Finding]:
    """A force at rest that is not as long as gravity, by more than the filters assume."""
    if "accel" not in live:
        return
    force = live["accel"][1]
    parts = force[: len(force) // ENOUGH * ENOUGH].reshape(-1, ENOUGH, 3)
    still = np.linalg.norm(parts.mean(axis=1), axis=1)[parts.std(axis=1).max(axis=1) < STILL_M_S2]
    if len(still) < FEWEST_STILL:
        return
    length = float(np.median(still))
    if USUAL_ERROR_M_S2 < abs(length - G_M_S2) < LARGEST_ERROR_M_S2:
        shown = f"the force at rest is {length:.2f} m/s2 long, {abs(length - G_M_S2):.2f} off gravity: more than filters assume by default"
        advice = "name the grade of the sensor (--grade consumer), or calibrate it (hnav calibrate)"
        yield Finding("note", "bias", "accel", shown, advice=advice)


def _field(recording: Recording, median: float) -> Iterator[Finding]:
    if FIELD_TESLA[0] <= median <= FIELD_TESLA[1]:
        return
    shown = f"median |field| {1e6 * median:.4g} uT"
    unit_read = recording.origin.units.get("mag") if recording.origin else None
    stated = unit_read is not None and unit_read.source != "assumed"
    hard_iron = stated and FIELD_TESLA[1] < median < HARD_IRON_TESLA  # which milligauss, taken for microtesla, are too
    if not hard_iron and (unit := _other_unit(recording, "mag", median, *EARTH_TESLA)):
        yield warning("unit", "mag", f"{shown}: this looks like {unit}", "mag_unit", unit)
    elif 0.75 <= median / si_per("mag", unit_name(recording, "mag")) <= 1.6:
        yield warning("unit", "mag", f"{shown}: this looks like an arbitrary unit", "mag_unit", "au")
    else:
        yield warning(
            "strength", "mag", f"{shown}, the Earth's is 22 to 67 uT", advice="hnav calibrate finds hard iron; or see mag_unit"
        )


# --------------------------------------------------------------------------------------------- samples


def _gaps(recording: Recording, live: Samples) -> Iterator[Finding]:
    for sensor, (t_s, _) in live.items():
        usual_s, steps_s = float(np.median(np.diff(t_s))), np.diff(t_s)
        if recording.t_s[-1] - t_s[-1] > max(ENDS_EARLY * (recording.t_s[-1] - recording.t_s[0]), ENDS_EARLY_S, 10 * usual_s):
            shown = f"its samples end at {t_s[-1]:.10g} s, the recording at {recording.t_s[-1]:.10g} s"
            advice = "look at the logger; samples packed at the top of a table need times of their own"
            yield warning("ends_early", sensor, shown, advice=advice)
        gaps = steps_s > max(GAP_S, 10 * usual_s)
        if gaps.any():
            longest = int(np.argmax(steps_s))
            count = "a gap" if gaps.sum() == 1 else f"{gaps.sum()} gaps, the longest"
            shown = f"{count} of {steps_s[longest]:.2f} s at {t_s[longest]:.10g} s"
            yield warning("gaps", sensor, shown, advice="what happened there is not known; look at the logger")


def _clipped(live: Samples) -> Iterator[Finding]:
    """Axes whose samples accumulate at their largest value."""
    for sensor, (_, values) in live.items():
        ends = [(axis, *at_end) for axis, column in zip("xyz", values.T) for at_end in _piled_up(column, CLIPPED_FROM[sensor])]
        if ends:
            axes = "".join(dict.fromkeys(axis for axis, _, _ in ends))
            size = min(size for _, size, _ in ends)
            count = sum(n for _, _, n in ends)
            shown = f"{count} samples of {axes} stand at {size:.4g} {UNIT_NAMES[sensor]}: the end of the range"
            advice = f"state the range by {RANGES[sensor]}={0.99 * size:.4g}, or use a wider range"
            yield warning("saturated", sensor, shown, advice=advice)


def _piled_up(column: np.ndarray, smallest: float) -> Iterator[tuple[float, int]]:
    """Value and number of the samples at an end of the range, if they are more than those just below it."""
    for end in (float(column.max()), float(column.min())):
        at_end = int(np.count_nonzero(column == end))
        beside = int(np.count_nonzero(np.abs(column - end) < CLIPPED_BAND * abs(end))) - at_end
        if abs(end) >= smallest and max(CLIPPED_SAMPLES, beside) <= at_end < len(column):
            yield abs(end), at_end


def _repeated(recording: Recording, live: Samples) -> Iterator[Finding]:
    if "gyro" in live and "accel" in live:
        both = np.hstack([recording.rate_b_rad_s, recording.force_b_m_s2])
        both = both[np.isfinite(both).all(axis=1)]
        repeats = (both[1:] == both[:-1]).all(axis=1)
        if len(both) >= ENOUGH and both.std(axis=0).any() and repeats.mean() > REPEATED_ROWS:
            shown = f"{100 * repeats.mean():.0f} % of the rows repeat the one before: they were written more often than measured"
            hold = (
                "and gyro_hold=instant with it, unless the gyroscope gives means of the interval before (FIFO, integrating chip)"
            )
            yield warning("repeated", "gyro", shown, "drop_repeats", "yes", hold)
    if "mag" in live:
        t_s, field = live["mag"]
        repeats = (field[1:] == field[:-1]).all(axis=1)
        if REPEATED_FIELDS < repeats.mean() < 1:
            rate_hz = (1 - repeats.mean()) / float(np.median(np.diff(t_s)))
            shown = f"{100 * repeats.mean():.0f} % of the samples repeat the one before: it measures at {rate_hz:.3g} Hz, and repeats count as news"
            yield warning("repeated", "mag", shown, "drop_repeats", "yes")


def warn_of_meaningless(
    t_s: np.ndarray, rate: npt.ArrayLike | None, force: npt.ArrayLike | None, field: npt.ArrayLike | None = None
) -> None:
    """A PlausibilityWarning, at the line that called the caller, for each finding in the first rows that makes an estimate meaningless.

    A field in another unit is named too: the heading never becomes ready. t_s: n; the others n x 3, as a filter takes them, or None.
    With few rows nothing is said.
    """
    t_s = t_s[:WARNED_ROWS]
    if len(t_s) < ENOUGH:
        return
    for name, values in (("rate_b_rad_s", rate), ("force_b_m_s2", force)):
        if values is None:
            shown = f"{name} is None: give it as n x 3; a filter that has only rates or only forces never becomes ready"
            warnings.warn(shown, PlausibilityWarning, stacklevel=3)
    if rate is None or force is None:
        return
    kept = np.concatenate([[True], t_s[1:] > np.maximum.accumulate(t_s)[:-1]])
    equal = float((np.diff(t_s) == 0).mean())
    if equal > STANDING_STAMPS:
        shown = f"time: {100 * equal:.0f} % of the time stamps equal the one before"
        cure = "give t_s as float64: float32 holds seconds since 1970 to 128 s"
        warnings.warn(f"{shown}; {cure}", PlausibilityWarning, stacklevel=3)
    if kept.sum() < ENOUGH:
        return
    rates, forces = (floats(values)[: len(t_s)][kept] for values in (rate, force))
    fields = None if field is None else floats(field)[: len(t_s)][kept]
    for finding in check(Recording("arrays", t_s[kept], rates, forces, fields)):
        if finding.stops or (finding.code, finding.sensor) == ("unit", "mag"):
            # Arrays have no option for a unit.
            known = finding.argument in ("gyro_unit", "accel_unit", "mag_unit", "time_unit")
            cure = f"multiply by {si_per(finding.sensor, finding.value):.6g}" if known else finding.cure
            cure = ARRAYS_OF_THE_SOUTH if finding.code == "sign" else cure
            warnings.warn(f"{finding.sensor}: {finding.message}; {cure}", PlausibilityWarning, stacklevel=3)
