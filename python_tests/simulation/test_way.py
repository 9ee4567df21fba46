"""A way through points: it meets them, it is smooth, and integrated sensor readings reproduce it."""

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from driven import brought_about, missed_m
from hnav import HnavValueError, earth
from hnav.fmi.fmus import Fmu, fmu_path
from hnav.simulation.vehicle import Drive, Vehicle, VehicleOptions
from hnav.simulation.way import FMU_POINTS, Way, read_way

# Round a block, over a hill; it stands from 20 to 25 s.
BLOCK = Way([0, 10, 20, 25, 30, 40, 50], [0, 100, 100, 100, 100, 30, 0], [0, 0, 80, 80, 120, 150, 90], [0, 0, 5, 5, 5, 20, 10])
PLACES = ((45, 10), (0, 179.9999), (89.9995, 10), (-90, 0))


def at_place(latitude_deg: float, longitude_deg: float, way: Way = BLOCK, **values) -> Vehicle:
    return Vehicle(way=way, latitude_rad=np.radians(latitude_deg), longitude_rad=np.radians(longitude_deg), **values)


def level_m(drive: Drive, start: np.ndarray) -> np.ndarray:
    """n x 3: along north, east and down of the start."""
    return (earth.position_of(drive.place) - earth.position_of(start)) @ earth.axes_at(start)


def velocity_e(drive: Drive) -> np.ndarray:
    return np.einsum("nij,nj->ni", earth.axes_at(drive.place), drive.velocity_n_m_s)


def attitude_e(drive: Drive) -> Rotation:
    return Rotation.from_matrix(earth.axes_at(drive.place)) * Rotation.from_quat(drive.q_nb[:, [1, 2, 3, 0]])


@pytest.mark.parametrize("place", PLACES, ids=str)
def test_points_are_met_anywhere_on_the_globe(place):
    drive = at_place(*place).run(BLOCK.t_s)
    start = np.array([*np.radians(place), 50.0])
    np.testing.assert_allclose(drive.place[:, 2] - 50, BLOCK.up_m, atol=1e-6)
    # What lies higher is farther from the axis of the Earth too.
    np.testing.assert_allclose(level_m(drive, start)[:, :2], np.column_stack([BLOCK.north_m, BLOCK.east_m]), atol=1e-3)


def test_far_points_keep_their_heights():
    far = Way([0, 1000, 3000], [0, 2e4, 1e5], [0, 1e5, 1e5], [0, 300, 0])
    drive = Vehicle(way=far).run(far.t_s)
    np.testing.assert_allclose(drive.place[:, 2], [50, 350, 50], atol=1e-6)


@pytest.mark.parametrize("place", PLACES, ids=str)
def test_velocity_rate_and_force_are_the_derivatives_of_what_they_move(place):
    step_s = 1e-3
    t_s = np.add.outer([-0.5, 3.3, 17.0, 22.0, 27.7, 44.4, 55.0], [-step_s, 0, step_s]).ravel()
    drive = at_place(*place, start_s=-2.0).run(t_s)
    before, now, after = (slice(i, None, 3) for i in range(3))
    position, velocity, body = earth.position_of(drive.place), velocity_e(drive), attitude_e(drive)
    earth_e = np.array([0, 0, earth.RATE_RAD_S])
    np.testing.assert_allclose(velocity[now], (position[after] - position[before]) / (2 * step_s), atol=2e-5)
    turn = (body[before].inv() * body[after]).as_rotvec() / (2 * step_s) + body[now].inv().apply(earth_e)
    np.testing.assert_allclose(drive.rate_b_rad_s[now], turn, atol=1e-6)
    force = (
        (velocity[after] - velocity[before]) / (2 * step_s)
        + 2 * np.cross(earth_e, velocity[now])
        - earth.gravity_at(position[now])
    )
    np.testing.assert_allclose(body[now].apply(drive.force_b_m_s2[now]), force, atol=3e-5)


def test_velocity_and_acceleration_are_continuous_and_the_body_points_where_it_goes():
    tiny_s = 1e-7
    t_s = np.sort(np.concatenate([BLOCK.t_s - tiny_s, BLOCK.t_s + tiny_s]))
    drive = at_place(45, 10, start_s=-1.0, way=Way(BLOCK.t_s + 1, BLOCK.north_m, BLOCK.east_m, BLOCK.up_m)).run(t_s)
    for values, tolerance in ((drive.velocity_n_m_s, 1e-5), (drive.force_b_m_s2, 1e-4), (drive.rate_b_rad_s, 1e-4)):
        np.testing.assert_allclose(values[1::2], values[::2], atol=tolerance)
    dense = at_place(45, 10).run(np.arange(0, 55, 0.1))
    speed = np.linalg.norm(dense.velocity_n_m_s, axis=1)
    body = Rotation.from_quat(dense.q_nb[:, [1, 2, 3, 0]])
    np.testing.assert_allclose(body.inv().apply(dense.velocity_n_m_s), np.outer(speed, [1, 0, 0]), atol=1e-9)
    np.testing.assert_allclose(body.apply([0, 1, 0])[:, 2], 0, atol=1e-12)  # no bank
    stands = (dense.t_s > 20) & (dense.t_s < 25)
    assert speed[stands].max() == 0 and speed[~stands].min() >= 0 and speed.max() < 25
    assert np.ptp(dense.heading_rad[stands]) < 1e-9


def test_a_straight_way_at_a_constant_speed_stays_one():
    way = Way.by_speed(12.0, np.linspace(0, 240, 5), np.linspace(0, 320, 5))
    np.testing.assert_allclose(way.t_s, np.linspace(0, 400 / 12, 5))
    drive = Vehicle(way=way).run(np.linspace(0, 60, 61))
    np.testing.assert_allclose(np.linalg.norm(drive.velocity_n_m_s, axis=1), 12, atol=1e-3)
    np.testing.assert_allclose(drive.heading_rad, np.arctan2(4, 3), atol=1e-4)


@pytest.mark.parametrize("place", PLACES, ids=str)
def test_means_of_rate_and_force_bring_the_way_about_in_the_filter(place):
    t_s = np.arange(5001) / 100
    drive = at_place(*place, mean_over_s=0.01).run(t_s)
    assert missed_m(brought_about(drive), drive) < 0.02


@pytest.mark.parametrize("version", (2, 3))
def test_the_fmu_takes_the_points_as_parameters(version):
    t_s = np.arange(0.0, 40.1, 5.0)
    drive = at_place(45, 10).run(t_s)
    with Fmu(fmu_path("Vehicle", version)) as fmu:
        fmu.set("motion.kind", "way")
        for name, value in {"place.longitude_rad": np.radians(10), **BLOCK.parameters()}.items():
            fmu.set(name, value)
        fmu.initialise()
        for k, end in enumerate(t_s[1:]):
            fmu.do_step(float(t_s[k]), float(end - t_s[k]))
            for part, expected in zip(("latitude", "longitude", "height"), drive.place[k + 1]):
                assert fmu.get(f"truth.{part}") == pytest.approx(expected, abs=1e-9)
    with Fmu(fmu_path("Vehicle", version)) as fmu, pytest.raises(HnavValueError, match="two points or more"):
        fmu.set("motion.kind", "way")
        fmu.initialise()


def test_tables_of_distances_and_of_places_give_the_same_way(tmp_path):
    drive = at_place(45, 10).run(BLOCK.t_s)
    rows = np.column_stack([1000 + BLOCK.t_s, np.degrees(drive.place[:, :2]), drive.place[:, 2]])
    (tmp_path / "places.csv").write_text(
        "t_s,lat_deg,lon_deg,alt_m\n" + "\n".join(",".join(map(repr, row)) for row in rows.tolist())
    )
    level = np.column_stack([BLOCK.t_s, BLOCK.north_m, BLOCK.east_m, BLOCK.up_m])
    (tmp_path / "level.csv").write_text(
        "# a block\nt_s,north_m,east_m,up_m\n" + "\n".join(",".join(map(repr, row)) for row in level.tolist())
    )
    places, distances = read_way(tmp_path / "places.csv"), read_way(tmp_path / "level.csv")
    for name in ("t_s", "north_m", "east_m", "up_m"):
        np.testing.assert_allclose(getattr(places, name), getattr(BLOCK, name), atol=1e-6)
        np.testing.assert_array_equal(getattr(distances, name), getattr(BLOCK, name))
    assert distances.start == {} and places.start["longitude_rad"] == pytest.approx(np.radians(10))
    moved = Vehicle(way=places).run([12.0])
    np.testing.assert_allclose(moved.place, at_place(45, 10).run([12.0]).place, atol=1e-8)
    again = pickle.loads(pickle.dumps(Vehicle(way=places)))
    np.testing.assert_array_equal(again.run([12.0]).place, moved.place)


@pytest.mark.parametrize(("head", "row", "says"), [
    ("t_s,north_m", "0,1", "a way has t_s and north_m, east_m or lat_deg, lon_deg"),
    ("t_s,north_m,east_m", "0,1,", "row 1 is no point"),
])  # fmt: skip
def test_tables_that_are_no_way_are_one_line(tmp_path, head, row, says):
    (tmp_path / "way.csv").write_text(f"{head}\n{row}\n")
    with pytest.raises(HnavValueError, match=says):
        read_way(tmp_path / "way.csv")


@pytest.mark.parametrize(("points", "says"), [
    (([0, 1], [0, 0], [0, 0]), "what stands is the kind rest"),
    (([0], [0], [0]), "two points or more"),
    (([0, 1, 2], [0, 10, 0], [0, 0, 0]), "turns back on itself at point 2"),
    (([0, 1], [0, 0], [0, 0], [0, 5]), "straight up behind point 1"),
    (([0, 0], [0, 1], [0, 0]), "point 2 .* less than 0.001 s after"),
    (([0, 1], [0, np.nan], [0, 0]), "point 2 .* not finite"),
    (([0, 1], [0, 1e7], [0, 0]), "point 2 .* farther than"),
])  # fmt: skip
def test_points_that_cannot_be_met_are_named(points, says):
    with pytest.raises(HnavValueError, match=says):
        Vehicle(way=Way(*points))


def test_a_way_belongs_to_its_kind():
    with pytest.raises(HnavValueError, match="kind = way: needs points"):
        Vehicle(kind="way")
    with pytest.raises(HnavValueError, match="points are for the kind way"):
        Vehicle(VehicleOptions(kind="car"), way=BLOCK)
    with pytest.raises(HnavValueError, match="east_m"):
        Way([0, 1], [0, 1], [0])
    with pytest.raises(HnavValueError, match="speed_m_s = 0"):
        Way.by_speed(0, [0, 1], [0, 0])
    with pytest.raises(HnavValueError, match="n x 3"):
        Way.through([0], [0, 1])
    with pytest.raises(HnavValueError, match="point 2 .* other side"):
        Way.through([0, 1], [[1, 1, 0], [-1, 1 - np.pi, 0]])
    long = np.arange(FMU_POINTS + 1.0)
    with pytest.raises(HnavValueError, match="takes 32"):
        Way(long, long, 0 * long).parameters()
