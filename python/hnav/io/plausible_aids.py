"""Whether positions, velocities and speeds of the same recording describe one track.

Over windows of 10 s the displacement of the positions is compared with the integral of the velocities, as complex numbers (north + i
east): as they are, with axes exchanged or negated, and with another scale, which is a unit. And the course has to turn when the rates do:
a delay shows stamps of arrival. Axes of rates and force are tested by hnav.io.accelerating.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hnav.io.accelerating import following_of
from hnav.io.aids import AidSamples, none_within
from hnav.io.findings import Finding, warning
from hnav.io.readers.aid_columns import PER
from hnav.io.readers.aids import NO_POSITIONS
from hnav.io.recordings import Recording
from hnav.io.turning import IDENTITY, integral, integral_over

EARTH_M = 6.371e6
REPEATED = 0.6  # share of fixes that equal the one before
ENOUGH = 50  # fixes
WINDOW_S, LONGEST_GAP_S = 10.0, 3.0
FEWEST_WINDOWS = 5
LEAST_WAY_M = 20.0  # rms in a window: above the noise of a receiver
COHERENT, CONTRADICTING = 0.9, 0.5
DIFFERENT, EQUAL = 0.4, 0.25  # relative difference of a track from what is compared with it
SAME_SCALE = 1.25
PAIR_S, MOVING_M_S, FEWEST_PAIRS, MOST_PAIRS = 2.0, 2.0, 30, 20_000  # of fixes whose courses are compared
LEVEL_S = 2.5  # either side, over which the mean force points up
LEAST_TURN_RAD = np.radians(5)  # standard deviation of the changes of course
MOST_LATE_S, LATE_STEP_S = 3.0, 0.02
FAR_LATE_S, FAR_STEP_S, FAR_PAIRS = 40.0, 0.25, 1000
"""As of GPS time, 18 s ahead of UTC, and TAI, 37 s; pairs that such a search takes."""
TURNS_TOGETHER, LATE_S, MORE_EXPLAINED = 0.93, 0.25, 0.01  # smaller delays are estimated by INS
WILD_RAD = 0.5
ABOVE_SEA = (
    "its heights are above sea level, and count as above the ellipsoid: they are off by the height of the geoid, -107 to 86 m"
)
GPS_AHEAD_S = 18.0
LEAST_OF_RANGE = 1e-3  # of the largest place, which a place in the right unit exceeds
HIGHEST_M = 1e5  # no atmosphere, and no receiver without a licence
FASTEST_CLIMB_M, NO_CLIMB = 200.0, 0.03  # rms in 10 s, of which a height shows no more: the velocity has another unit
DEGREES = float(np.degrees(1))
OPEN_SEA, NEAR_ORIGIN_DEG = (90.0, 180.0), 0.1
"""Latitude and longitude in rad are within pi / 2 and pi: as degrees, a place in the Gulf of Guinea. A simulation may be at the origin itself."""
LARGEST_SIGMA = {"position": (200.0, "m", "mm", ("sigma_h", "sigma_v")), "velocity": (20.0, "m/s", "mm/s", ("sigma_vel",))}
"""Median that no receiver with a fix states, its unit, the unit that it looks like, and the columns."""
IN_RADIANS = {"lat_deg lon_deg": (DEGREES, DEGREES, 1.0), "lat_deg": (DEGREES, 1.0, 1.0), "lon_deg": (1.0, DEGREES, 1.0)}
"""Columns that may hold radians, and the factors that make degrees of them."""
NEAR_UNIT = 1.12  # ratio to a unit's factor


def check_aids(recording: Recording) -> list[Finding]:
    """Implausible aiding samples, which attitude filters do not read."""
    found = [*_left_out(recording), *_of_another_clock(recording), *_repeated(recording), *_large_sigmas(recording)]
    position, velocity, speed = (_in_time(recording.aids.get(kind)) for kind in ("position", "velocity", "speed"))
    if position is None:
        return found + _of_motion(recording, velocity)
    if out_of_range := [*_out_of_range(position)]:
        return found + _of_motion(recording, velocity) + out_of_range
    if velocity is None:
        found += _at_sea(position)
    if position.above_sea:
        found.append(Finding("note", "datum", "position", ABOVE_SEA, advice="a column of heights above the ellipsoid goes first"))
    north_east_up = _metres(position)
    if velocity is not None:
        of_track = [*_against_velocity(position, north_east_up[:, :2], velocity)]
        # Velocities that contradict the positions are no measure of rates and force.
        found += of_track or _of_motion(recording, velocity)
        if "unit" not in {finding.code for finding in of_track}:
            found += _against_climb(position.t_s, north_east_up[:, 2:], velocity)
    if speed is not None and ("unit", "position") not in {(finding.code, finding.sensor) for finding in found}:
        found += _against_speed(position.t_s, north_east_up, speed)
    return found


def _left_out(recording: Recording) -> Iterator[Finding]:
    """Positions of which the file has a part."""
    for note in recording.origin.notes if recording.origin else ():
        if note.startswith(NO_POSITIONS):
            advice = "name it by columns ROLE=NAME, or add it; alt_m may be a rough constant"
            yield warning("absent", "position", note, advice=advice)


def _of_another_clock(recording: Recording) -> Iterator[Finding]:
    """Kinds of which no sample lies within the rows: no filter uses them."""
    begin_s, end_s = float(recording.t_s[0]), float(recording.t_s[-1])
    for kind, one in recording.aids.items():
        if none_within(one.t_s, begin_s, end_s):
            shown = f"times from {one.t_s.min():.10g} to {one.t_s.max():.10g} s, the rows have {begin_s:.10g} to {end_s:.10g} s"
            yield warning("clock", kind, shown, advice="name the column of their common clock: columns t_s=NAME", certain=True)


def _of_motion(recording: Recording, velocity: AidSamples | None) -> list[Finding]:
    """Rates and force by the changes of the velocity."""
    if velocity is None:
        return []
    return [*_against_turning(recording, velocity), *_against_acceleration(recording, velocity)]


def _in_time(samples: AidSamples | None) -> AidSamples | None:
    """The horizontal ones in the order of their validity; None for fewer than two."""
    if samples is None:
        return None
    order = np.argsort(samples.t_s, kind="stable")
    kept = samples.rows(order[np.isfinite(samples.values[order][:, :2]).all(axis=1)])
    return kept if len(kept.t_s) > 1 else None


def _repeated(recording: Recording) -> Iterator[Finding]:
    for kind in ("position", "velocity"):
        one = recording.aids.get(kind)
        if one is None or len(one.t_s) < max(ENOUGH, 0.5 * len(recording.t_s)):
            continue
        share = 1 - len(one.without_repeats().t_s) / len(one.t_s)
        if share > REPEATED:
            shown = f"{100 * share:.0f} % of the rows repeat the fix before: each would count as a new one"
            yield warning("repeated", kind, shown, "drop_repeats", "yes")


def _out_of_range(position: AidSamples) -> Iterator[Finding]:
    """Places that are none."""
    degrees, height_m = np.degrees(position.values[:, :2]), position.values[:, 2:]
    for name, role, values, quantity, largest in (
        ("latitude", "lat_deg", degrees[:, 0], "angle", 90.0),
        ("longitude", "lon_deg", degrees[:, 1], "angle", 360.0),
        ("height", "alt_m", height_m, "length", HIGHEST_M),
    ):
        size = float(np.nanmax(np.abs(values), initial=0.0))
        if size > largest:
            small = {unit: size * factor for unit, factor in PER[quantity].items() if factor < 0.1}
            units = [unit for unit, scaled in small.items() if LEAST_OF_RANGE * largest <= scaled <= largest]
            looks = f"this looks like {units[0]}" if units else "latitude and longitude may be exchanged"
            shown = f"a {name} of {size:.5g} {next(iter(PER[quantity]))}, where {largest:g} is the largest: {looks}"
            yield warning("unit", "position", shown, advice=_say_unit(units[0] if units else "", role), certain=True)


def _at_sea(position: AidSamples) -> Iterator[Finding]:
    """Places that are in radians, for all that they show without velocities."""
    largest = np.degrees(np.abs(position.values[:, :2]).max(axis=0))
    if (largest <= np.radians(OPEN_SEA)).all() and largest.max() > NEAR_ORIGIN_DEG:
        shown = f"latitude and longitude up to {largest[0]:.3g} and {largest[1]:.3g} deg are in the Gulf of Guinea: this looks like rad"
        yield warning("unit", "position", shown, advice=_say_unit("rad", "lat_deg", "lon_deg"))


def _large_sigmas(recording: Recording) -> Iterator[Finding]:
    """Stated sigmas so large that the samples would count for nothing."""
    for kind, (largest, unit, other, roles) in LARGEST_SIGMA.items():
        stated = recording.aids[kind].sigma if kind in recording.aids else np.empty((0, 3))
        stated = stated[np.isfinite(stated)]
        if len(stated) and (median := float(np.median(stated))) > largest:
            shown = f"a median stated sigma of {median:.3g} {unit}: this looks like {other}"
            yield warning("unit", kind, shown, advice=_say_unit(other, *roles))


def _say_unit(unit: str, *roles: str) -> str:
    """How the unit of columns is given."""
    said = " ".join(f'columns {role}="NAME [{unit}]"' for role in roles or ("ROLE",))
    return f"say it behind the name, {said}, or in the header" if unit else "see the columns, and the unit"


def _metres(position: AidSamples) -> np.ndarray:
    """n x 3: north, east, up of the first fix, on a sphere: to half a percent."""
    latitude, longitude, height = position.values.T
    east_rad = np.angle(np.exp(1j * (longitude - longitude[0])))
    return np.stack([EARTH_M * (latitude - latitude[0]), EARTH_M * np.cos(latitude[0]) * east_rad, np.nan_to_num(height)], -1)


def _windows(t_s: np.ndarray, positions: np.ndarray, of: AidSamples, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement of the positions, and integral of the values, over windows without a gap in either; each k x its columns."""
    at = np.arange(max(t_s[0], of.t_s[0]), min(t_s[-1], of.t_s[-1]), WINDOW_S)
    known = np.isfinite(values).all(axis=1)
    times, values = of.t_s[known], values[known]
    if len(at) < FEWEST_WINDOWS + 1 or len(times) < 2:
        return np.empty((0, positions.shape[1])), np.empty((0, values.shape[1]))
    there = np.diff(np.stack([np.interp(at, t_s, column) for column in positions.T], -1), axis=0)
    travelled = integral_over(times, values, at)
    whole = np.ones(len(at) - 1, bool)
    for clock in (t_s, times):
        for begin_s in clock[:-1][np.diff(clock) > LONGEST_GAP_S]:
            end_s = clock[np.searchsorted(clock, begin_s) + 1]
            whole[max(0, np.searchsorted(at, begin_s) - 1) : np.searchsorted(at, end_s)] = False
    return there[whole], travelled[whole]


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def _difference(one: np.ndarray, other: np.ndarray) -> float:
    """Relative to the larger: 0 if they are equal, about 1 if they have nothing in common."""
    return _rms(one - other) / max(_rms(one), _rms(other), 1e-9)


def _unit(scale: float) -> str:
    """The unit that velocities in m/s seem to have, or nothing; scale: displacement to travelled."""
    for name, factor in PER["velocity"].items():
        if name != "m/s" and 1 / NEAR_UNIT < scale / factor < NEAR_UNIT:
            return name
    return ""


def _other_scale(sensor: str, shown: str, scale: float) -> Finding:
    """That velocities or speeds have another unit; scale: displacement to travelled."""
    unit = _unit(scale)
    looks = f"this looks like {unit}, which is {PER['velocity'][unit]:.4g} m/s" if unit else f"a factor of {scale:.3g}"
    return warning("unit", sensor, f"{shown}: {looks}", advice=_say_unit(unit), certain=True)


def _against_velocity(position: AidSamples, north_east: np.ndarray, velocity: AidSamples) -> Iterator[Finding]:
    there, travelled = _windows(position.t_s, north_east, velocity, velocity.values[:, :2])
    if len(there) < FEWEST_WINDOWS:
        return
    D, T = there @ [1, 1j], travelled @ [1, 1j]
    if max(_rms(D), _rms(T)) < LEAST_WAY_M or _difference(D, T) < DIFFERENT:
        return
    exchanged, *radians = (
        _windows(position.t_s, _metres(replace(position, values=values))[:, :2], velocity, velocity.values[:, :2])[0] @ [1, 1j]
        for values in (position.values[:, [1, 0, 2]], *(position.values * factors for factors in IN_RADIANS.values()))
    )
    fits = {
        "latitude and longitude look exchanged": _difference(exchanged, T),
        **{roles: _difference(moved, T) for roles, moved in zip(IN_RADIANS, radians)},
        "north and east look exchanged": _difference(D, 1j * T.conj()),
        "east looks negated": _difference(D, T.conj()),
        "north looks negated": _difference(D, -T.conj()),
        "north and east look negated": _difference(D, -T),
    }
    best = min(fits, key=lambda name: fits[name])
    coherence, scale = abs(np.vdot(T, D)) / max(len(D) * _rms(D) * _rms(T), 1e-9), _rms(D) / max(_rms(T), 1e-9)
    shown = f"over 10 s the positions move by {_rms(D):.3g} m, the velocities by {_rms(T):.3g} m (rms)"
    if fits[best] < EQUAL and best in IN_RADIANS:
        looks = f"{' and '.join(best.split())} look{'' if ' ' in best else 's'} like rad"
        yield warning("unit", "position", f"{shown}: {looks}", advice=_say_unit("rad", *best.split()), certain=True)
    elif fits[best] < EQUAL:
        shown = f"the velocities contradict the positions: {best}"
        yield warning("axes", "velocity", shown, advice="see the columns", certain=True)
    elif coherence > COHERENT and not 1 / SAME_SCALE < scale < SAME_SCALE:
        yield _other_scale("velocity", shown, scale)
    elif coherence < CONTRADICTING:
        shown += ", in unrelated directions"
        yield warning("contradiction", "velocity", shown, advice="see the columns, and the clocks of both")


def _against_climb(t_s: np.ndarray, up: np.ndarray, velocity: AidSamples) -> Iterator[Finding]:
    """Sign and unit of the vertical velocity, where either says that the height changes enough."""
    there, travelled = _windows(t_s, up, velocity, -velocity.values[:, 2:])
    if len(there) < FEWEST_WINDOWS or not there.any():  # a rough constant may stand for a height
        return
    up_m, travelled_m = _rms(there), _rms(travelled)
    if max(up_m, travelled_m) < LEAST_WAY_M or _difference(there, travelled) < DIFFERENT:
        return
    coherence = float(np.vdot(travelled, there)) / max(len(there) * up_m * travelled_m, 1e-9)
    same = 1 / SAME_SCALE < up_m / max(travelled_m, 1e-9) < SAME_SCALE
    if (coherence > COHERENT and not same) or (travelled_m > FASTEST_CLIMB_M and up_m < NO_CLIMB * travelled_m):
        shown = f"over 10 s the height changes by {up_m:.3g} m, the vertical velocity says {travelled_m:.3g} m (rms)"
        yield _other_scale("velocity", shown, up_m / travelled_m)
    elif coherence < -COHERENT:
        shown = "the height rises while the vertical velocity says down"
        yield warning("sign", "velocity", shown, advice="down is positive: negate it", certain=True)


def _against_turning(recording: Recording, velocity: AidSamples) -> Iterator[Finding]:
    """How much later than the rates the course turns."""
    t_s, turned = _turn_about_the_vertical(recording)
    course = np.arctan2(velocity.values[:, 1], velocity.values[:, 0])
    begin, end = _pairs(velocity, t_s)
    if len(begin) < FEWEST_PAIRS:
        return
    change = np.angle(np.exp(1j * (course[end] - course[begin])))
    if change.std() < LEAST_TURN_RAD:
        return

    def best_of(lags_s: np.ndarray, every: int = 1) -> tuple[float, float]:
        ends_s = [velocity.t_s[at[::every]] for at in (begin, end)]
        shifted = ([np.interp(at_s - lag_s, t_s, turned) for at_s in ends_s] for lag_s in lags_s)
        fits = [_share_explained(change[::every], *angles) for angles in shifted]
        return float(lags_s[np.argmax(fits)]), max(fits)

    _, now = best_of(np.zeros(1))
    late_s, best = best_of(np.arange(-MOST_LATE_S, MOST_LATE_S + LATE_STEP_S, LATE_STEP_S))
    if best < TURNS_TOGETHER:
        far_s, _ = best_of(np.arange(-FAR_LATE_S, FAR_LATE_S + FAR_STEP_S, FAR_STEP_S), 1 + len(begin) // FAR_PAIRS)
        late_s, best = best_of(far_s + np.arange(-FAR_STEP_S, FAR_STEP_S + LATE_STEP_S, LATE_STEP_S))
    if best > TURNS_TOGETHER and abs(late_s) > LATE_S and best - now > MORE_EXPLAINED:
        shown = f"the course turns {abs(late_s):.2g} s {'later' if late_s > 0 else 'earlier'} than the rates"
        shown += ", as GPS time is ahead of UTC by 18 s" if abs(abs(late_s) - GPS_AHEAD_S) < 1 else ""
        yield warning("clock", "velocity", shown, "fixes_late_s", f"{late_s:.2g}", "times of arrival are no times of validity")


def _against_acceleration(recording: Recording, velocity: AidSamples) -> Iterator[Finding]:
    """Axes of rates and force with which the body cannot have moved so."""
    gyro, force = recording.samples("gyro"), recording.samples("accel")
    if len(gyro[0]) < 2 or len(force[0]) < 2 or (following := following_of(gyro, force, velocity)) is None or not following.off:
        return
    now, best = float(following.error[0, IDENTITY]), float(following.error.min())
    shown = f"the axes do not fit: force and rates miss the changes of the satellite velocity by {now:.2g} m/s each second, "
    if (axes := following.axes) is None:
        shown += f"with several other axes by {best:.2g}"
        yield warning("axes", "gyro", shown, advice="see which axes of rates or force are exchanged or negated", certain=True)
        return
    advice = "both are mirrored: look up which axis is" if len(axes) > 1 else ""
    value = ",".join(f"{sensor}={text}" for sensor, text in axes.items())
    yield warning("axes", next(iter(axes)), f"{shown}with these by {best:.2g}", "axes", value, advice, certain=True)


def _turn_about_the_vertical(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Times of the rates, and the angle by which the body has turned about the mean direction of the force."""
    whole = np.isfinite(recording.rate_b_rad_s).all(axis=1) & np.isfinite(recording.force_b_m_s2).all(axis=1)
    t_s, rate, force = recording.t_s[whole], recording.rate_b_rad_s[whole], recording.force_b_m_s2[whole]
    if len(t_s) < 2:
        return t_s, np.zeros(len(t_s))
    summed = np.vstack([np.zeros(3), np.cumsum(force, axis=0)])
    first, last = (np.searchsorted(t_s, t_s + side * LEVEL_S) for side in (-1, 1))
    up = summed[last] - summed[first]
    down = -up / np.maximum(np.linalg.norm(up, axis=1), 1e-9)[:, None]
    about = np.einsum("ij,ij->i", rate, down)
    return t_s, integral(t_s, about[:, None], t_s)[:, 0]


def _pairs(velocity: AidSamples, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places of fixes PAIR_S apart that both move, within the times of the rates however late they are."""
    if len(t_s) < 2:
        return np.empty(0, int), np.empty(0, int)
    begin = np.arange(len(velocity.t_s))
    end = np.searchsorted(velocity.t_s, velocity.t_s + PAIR_S - 1e-6)
    begin, end = begin[end < len(begin)], end[end < len(begin)]
    moves = np.hypot(*velocity.values[:, :2].T) > MOVING_M_S
    inside = (velocity.t_s[begin] > t_s[0] + MOST_LATE_S) & (velocity.t_s[end] < t_s[-1] - MOST_LATE_S)
    kept = moves[begin] & moves[end] & inside & (velocity.t_s[end] - velocity.t_s[begin] < 2 * PAIR_S)
    return begin[kept][:MOST_PAIRS], end[kept][:MOST_PAIRS]


def _share_explained(change: np.ndarray, before: np.ndarray, after: np.ndarray) -> float:
    """Share of the variance of the changes of course that a turn explains, but for a steady bias; a wild change counts little."""
    left, all_of_it = (np.clip(one - np.median(one), -WILD_RAD, WILD_RAD) for one in (change - (after - before), change))
    return float(1 - np.mean(left**2) / np.mean(all_of_it**2))


def _against_speed(t_s: np.ndarray, north_east_up: np.ndarray, speed: AidSamples) -> Iterator[Finding]:
    there, travelled = _windows(t_s, north_east_up[:, :2], speed, np.abs(speed.values))
    moved = np.abs(there @ [1, 1j])
    far = moved > LEAST_WAY_M
    if far.sum() < FEWEST_WINDOWS:
        return
    scale = float(np.median(moved[far] / np.maximum(travelled[far, 0], 1e-9)))
    if not 1 / SAME_SCALE < scale < SAME_SCALE:
        shown = f"over 10 s the positions move by {np.median(moved[far]):.3g} m, the speed by {np.median(travelled[far, 0]):.3g} m (median)"
        yield _other_scale("speed", shown, scale)
