"""Positions, velocities and speeds that describe different tracks."""

import dataclasses
import re

import numpy as np
import pytest

from hnav.earth import axes_at, place_of, position_of
from hnav.io.aids import AidSamples
from hnav.io.plausible_aids import check_aids
from hnav.io.readers import read_aids
from hnav.io.readers.aid_columns import PER
from hnav.io.recordings import Recording, RecordingError

PLACE = np.array([0.84, 0.2, 300.0])


SLOWLY, QUICKLY = (1.3, 0.05), (0.6, 0.3)
"""Amplitude in rad and angular frequency in rad/s of a winding road."""


def driven(noise_m: float = 2.0, climb_m_s: float = 0.0, length_s: float = 200.0, winding=SLOWLY, faster=0.0) -> Recording:
    """A car on a winding road, 15 m/s, with a fix each second; climb_m_s: of an aircraft instead."""
    rng = np.random.default_rng(5)
    t = np.arange(0, length_s, 1.0)
    course = 0.4 + winding[0] * np.sin((winding[1] + faster * t) * t) + 0.01 * t
    velocity = np.stack([15 * np.cos(course), 15 * np.sin(course), -climb_m_s * np.sin(0.07 * t)], 1)
    way = np.vstack([np.zeros(3), np.cumsum(0.5 * (velocity[1:] + velocity[:-1]), axis=0)])
    place = place_of(position_of(PLACE) + (way + noise_m * rng.normal(size=way.shape)) @ axes_at(PLACE).T)
    samples = {
        "position": (place, 2.0),
        "velocity": (velocity + 0.1 * rng.normal(size=way.shape), 0.1),
        "speed": (np.hypot(*velocity[:, :2].T)[:, None], 0.1),
    }
    aids = {kind: AidSamples(t, values, np.full(values.shape, sigma)) for kind, (values, sigma) in samples.items()}
    often = np.arange(0, length_s, 0.1)
    rows = np.zeros((len(often), 3))
    return Recording("road", often, rows, rows + [0, 0, -9.81], None, aids=aids)


def with_values(recording: Recording, kind: str, values: np.ndarray) -> Recording:
    return dataclasses.replace(recording, aids={**recording.aids, kind: dataclasses.replace(recording.aids[kind], values=values)})


def test_one_track_is_plausible_with_the_noise_of_a_receiver():
    for recording in (driven(), driven(noise_m=5.0), driven(climb_m_s=5.0)):
        assert check_aids(recording) == []


@pytest.mark.parametrize("kind", ["velocity", "speed"])
@pytest.mark.parametrize("unit", [name for name in PER["velocity"] if name != "m/s"])
def test_another_unit_of_the_speed_is_named(kind, unit):
    recording = driven()
    (finding,) = check_aids(with_values(recording, kind, recording.aids[kind].values / PER["velocity"][unit]))
    assert (finding.code, finding.sensor) == ("unit", kind) and f"looks like {unit}," in finding.message


@pytest.mark.parametrize(
    "kind, values, said",
    [
        ("position", lambda v: v[:, [1, 0, 2]], "latitude and longitude look exchanged"),
        ("velocity", lambda v: v[:, [1, 0, 2]], "north and east look exchanged"),
        ("velocity", lambda v: v * [1, -1, 1], "east looks negated"),
        ("velocity", lambda v: v * [-1, 1, 1], "north looks negated"),
        ("velocity", lambda v: v * [-1, -1, 1], "north and east look negated"),
        ("velocity", lambda v: v * [1, 1, -1], "the height rises while the vertical velocity says down"),
    ],
)
def test_axes_that_contradict_the_track_are_named(kind, values, said):
    recording = driven(climb_m_s=5.0)
    (finding,) = check_aids(with_values(recording, kind, values(recording.aids[kind].values)))
    assert finding.level == "warning" and said in finding.message


def test_velocities_of_another_drive_are_in_unrelated_directions():
    recording = driven(length_s=400.0)
    turning = np.exp(1j * np.random.default_rng(2).uniform(0, 2 * np.pi, 40)).repeat(10)
    other = np.stack([15 * turning.real, 15 * turning.imag, 0 * turning.real], 1)
    (finding,) = check_aids(with_values(recording, "velocity", other))
    assert finding.code == "contradiction" and "unrelated directions" in finding.message


def test_a_body_that_hardly_moves_and_one_with_gaps_show_nothing():
    still = driven()
    nothing = with_values(still, "position", np.tile(PLACE, (200, 1)))
    assert check_aids(with_values(nothing, "velocity", np.zeros((200, 3)))) == []
    seldom = {kind: one.rows(np.arange(0, 200, 5)) for kind, one in still.aids.items()}
    seldom["velocity"] = dataclasses.replace(seldom["velocity"], values=3.6 * seldom["velocity"].values)
    assert check_aids(dataclasses.replace(still, aids=seldom)) == []


def turning_with_the_road(late_s: float) -> Recording:
    """The car of driven() with rates that turn it, and velocities that are stamped late."""
    faster = 0.001  # rad/s2: bends that repeat would leave the delay open
    road = driven(length_s=240.0, winding=QUICKLY, faster=faster)
    often = road.t_s
    rate = np.zeros((len(often), 3))
    phase, speed = (QUICKLY[1] + faster * often) * often, QUICKLY[1] + 2 * faster * often
    rate[:, 2] = QUICKLY[0] * speed * np.cos(phase) + 0.02  # with a bias
    aids = {kind: dataclasses.replace(one, t_s=one.t_s + late_s) for kind, one in road.aids.items() if kind != "speed"}
    return dataclasses.replace(road, rate_b_rad_s=rate, aids=aids)


@pytest.mark.parametrize("late_s", [0.6, 1.5, -0.6, 5.0, 18.0, -18.0])
def test_fixes_that_are_stamped_late_are_said_with_the_delay(late_s):
    (finding,) = check_aids(turning_with_the_road(late_s))
    assert (finding.code, finding.argument) == ("clock", "fixes_late_s") and abs(float(finding.value) - late_s) < 0.1
    assert ("GPS time" in finding.message) == (abs(late_s) == 18.0)
    assert check_aids(turning_with_the_road(0.1)) == []


@pytest.mark.parametrize("unit, factor", [("mm/s", 1000.0), ("km/h", 3.6)])
def test_another_unit_of_the_vertical_velocity_alone_is_named(unit, factor):
    recording = driven(climb_m_s=5.0)
    (finding,) = check_aids(with_values(recording, "velocity", recording.aids["velocity"].values * [1, 1, factor]))
    assert (finding.code, finding.sensor) == ("unit", "velocity") and f"looks like {unit}, which is" in finding.message
    noisy = driven()  # on level ground: only how large it is shows
    spoilt = noisy.aids["velocity"].values * [1, 1, 0] + np.outer(np.sin(np.arange(200) / 30), [0, 0, 100.0])
    (finding,) = check_aids(with_values(noisy, "velocity", spoilt))
    assert finding.code == "unit" and "the vertical velocity says" in finding.message
    flat = noisy.aids["position"].values * [1, 1, 0] + [0, 0, 300.0]
    assert check_aids(with_values(with_values(noisy, "velocity", spoilt), "position", flat)) == []


@pytest.mark.parametrize("roles", [("lat_deg", "lon_deg"), ("lat_deg",), ("lon_deg",)])
def test_places_in_radians_are_named(roles):
    recording = driven()
    powers = np.array(["lat_deg" in roles, "lon_deg" in roles, False], int)
    (finding,) = check_aids(with_values(recording, "position", np.radians(1.0) ** powers * recording.aids["position"].values))
    assert (finding.code, finding.sensor) == ("unit", "position") and finding.stops
    assert f"{' and '.join(roles)} look" in finding.message
    assert finding.advice.startswith(
        "say it behind the name, " + " ".join(f'columns {role}="NAME [rad]"' for role in roles) + ","
    )


def test_places_in_radians_are_named_without_velocities_too():
    alone = dataclasses.replace(driven(), aids={"position": driven().aids["position"]})
    degrees = alone.aids["position"].values
    assert check_aids(alone) == []
    (finding,) = check_aids(with_values(alone, "position", np.radians([1.0, 1.0, 57.3]) * degrees))
    assert "Gulf of Guinea: this looks like rad" in finding.message and 'columns lat_deg="NAME [rad]"' in finding.advice
    assert check_aids(with_values(alone, "position", degrees - [*PLACE[:2], 0])) == []  # a simulation at (0, 0)


@pytest.mark.parametrize(
    "kind, factor, said", [("position", 1e3, "2e+03 m: this looks like mm;"), ("velocity", 1e3, "100 m/s: this looks like mm/s;")]
)
def test_sigmas_in_millimetres_are_named(kind, factor, said):
    recording = driven()
    stated = dataclasses.replace(recording.aids[kind], sigma=factor * recording.aids[kind].sigma)
    (finding,) = check_aids(dataclasses.replace(recording, aids={**recording.aids, kind: stated}))
    assert f"a median stated sigma of {said}" in str(finding)


@pytest.mark.parametrize("factors, said", [
    ([1e7, 1e7, 1], r"a latitude of 4\.\d+e\+08 deg, where 90 is the largest: this looks like 1e7deg"),
    ([1, 1, 1e3], r"a height of 3\.\d+e\+05 m, where 100000 is the largest: this looks like mm"),
    ([2, 1, 1], r"a latitude of 96\.\d+ deg, .* latitude and longitude may be exchanged"),
])  # fmt: skip
def test_places_that_are_none_are_named(factors, said):
    recording = driven()
    finding, *more = check_aids(with_values(recording, "position", recording.aids["position"].values * factors))
    assert re.match(said, finding.message) and finding.stops
    assert [one.message.split()[1] for one in more] == (["longitude"] if factors[1] > 1 else [])
    if factors[1] > 1:
        assert 'columns lat_deg="NAME [1e7deg]"' in finding.advice and 'columns lon_deg="NAME [1e7deg]"' in more[0].advice


@pytest.mark.parametrize("given, factor", [("speed N [km/h]", 1 / 3.6), ("-speed N [kn]", -1852 / 3600), ("speed N", 1.0)])
def test_a_unit_may_stand_behind_the_name_of_a_column(tmp_path, given, factor):
    path = tmp_path / "fixes.csv"
    path.write_text("t_s,speed N,ve\n" + "".join(f"{t},7.2,0\n" for t in range(5)))
    velocity = read_aids(path, columns={"vn": given})["velocity"]
    np.testing.assert_allclose(velocity.values[:, 0], 7.2 * factor)
    with pytest.raises(RecordingError, match=r"columns vn=speed N \[kg\]: .* cannot have this unit"):
        read_aids(path, columns={"vn": "speed N [kg]"})


@pytest.mark.parametrize(
    "name, factor",
    [("Tacho_kmh", 1 / 3.6), ("tachoKn", 1852 / 3600), ("Tacho [km/h]", 1 / 3.6), ("speed_wheel_m_s", 1.0), ("Tacho", 1.0)],
)
def test_the_unit_in_the_name_of_a_column_that_is_assigned_counts(tmp_path, name, factor):
    path = tmp_path / "wheels.csv"
    path.write_text(f"t_s,{name}\n" + "".join(f"{t},7.2\n" for t in range(5)))
    np.testing.assert_allclose(read_aids(path, columns={"speed_m_s": name})["speed"].values, 7.2 * factor)


def test_a_plain_height_beside_a_place_is_its_height(tmp_path):
    path = tmp_path / "fixes.csv"
    path.write_text("t_s,lat,lon,height\n" + "".join(f"{t},48.1,11.6,{500 + t}\n" for t in range(5)))
    np.testing.assert_allclose(read_aids(path)["position"].values[:, 2], 500 + np.arange(5))
