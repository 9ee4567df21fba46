"""The FMUs of a vehicle and of the aids of its inertial sensor: Vehicle, Gnss, Baro, Wheel."""

import fmpy
import numpy as np
import pytest

from hnav import earth
from hnav.errors import HnavError
from hnav.fmi.fmus import Fmu, fmu_path
from hnav.simulation.vehicle import Vehicle
from makers.navigation import READ, READ_BY_SENSOR, STATED

VERSIONS = (2, 3)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
SENSORS = {"Gnss": "gnss_receiver", "Baro": "barometer", "Wheel": "wheel_sensor"}
TRUTH = [*dict.fromkeys([*READ["gnss_receiver"], *READ_BY_SENSOR])]
AIRCRAFT = {"motion.kind": "aircraft", "seed": 5}
SILENT = {"gnss.noise_m[1]": 1e-9, "gnss.noise_m[2]": 1e-9, "gnss.noise_m_s[1]": 1e-9, "gnss.noise_m_s[2]": 1e-9, "gnss.colour_m[1]": 0.0,
          "gnss.colour_m[2]": 0.0}  # fmt: skip
STEPS = ([0.01] * 200, [0.04] * 50, [0.01, 0.03] * 50)


def opened(name: str, version: int = 2, parameters=None, model_exchange: bool = False) -> Fmu:
    fmu = Fmu(fmu_path(name, version), model_exchange)
    for parameter, value in (parameters or {}).items():
        fmu.set(parameter, value)
    return fmu


def described(name: str, version: int, causality: str) -> dict:
    variables = fmpy.read_model_description(str(fmu_path(name, version))).modelVariables
    return {v.name: (v.type, v.unit) for v in variables if v.causality == causality}


def truths_of(name: str, t_s: np.ndarray, vehicle: Vehicle) -> dict[str, np.ndarray]:
    """The readings of a sensor on a vehicle at these times."""
    drive = vehicle.run(t_s)
    vectors = {"velocity": drive.velocity_n_m_s, "q": drive.q_nb, "rate": drive.rate_b_rad_s}
    found = dict(zip(("truth.latitude", "truth.longitude", "truth.height"), drive.place.T))
    found |= {f"truth.{what}[{i}]": values for what, table in vectors.items() for i, values in enumerate(table.T, 1)}
    return {variable: found[variable] for variable in READ[SENSORS[name]]}


def sampled(
    name: str, parameters=None, seconds: float = 3.0, version: int = 2, step_s: float = 0.1, vehicle=None, start_s=0.0
) -> dict[str, np.ndarray]:
    """The named outputs after each step, and the time as t_s."""
    vehicle = vehicle or Vehicle(seed=5, start_s=start_s)
    points = start_s + step_s * np.arange(round(seconds / step_s))
    truth, rows = truths_of(name, points, vehicle), []
    with opened(name, version, parameters) as fmu:
        fmu.initialise(start_s)
        for k, t_s in enumerate(points):
            for variable, values in truth.items():
                fmu.set(variable, float(values[k]))
            fmu.do_step(float(t_s), step_s)
            rows.append([start_s + (k + 1) * step_s, *(float(fmu.get(output)) for output in STATED[SENSORS[name]])])
    return dict(zip(["t_s", *STATED[SENSORS[name]]], np.array(rows).T))


# --------------------------------------------------------------------------------------------- descriptions


@versions
def test_outputs_bear_the_names_types_and_units_of_the_inputs_they_feed(version):
    vehicle, ins = described("Vehicle", version, "output"), described("Ins", version, "input")
    for name, component in SENSORS.items():
        inputs, outputs = described(name, version, "input"), described(name, version, "output")
        assert sorted(inputs) == sorted(READ[component])
        assert inputs == {variable: vehicle[variable] for variable in inputs}
        fed = {variable: ins[variable] for variable in ins if variable.split(".")[0] in (name.lower(), f"{name.lower()}vel")}
        assert fed == {variable: outputs[variable] for variable in STATED[component]}
    assert {variable: vehicle[variable] for variable in READ_BY_SENSOR} == described("ImuMagSensor", version, "input")


@pytest.mark.parametrize("name", SENSORS)
def test_a_sensor_has_the_parameters_of_its_own_group(name):
    assert {parameter.split(".")[0] for parameter in described(name, 3, "parameter")} == {name.lower(), "seed"}


# --------------------------------------------------------------------------------------------- the vehicle


def truths(version: int, steps: list[float], start_s: float = 0.0) -> list[float]:
    """At the end."""
    with opened("Vehicle", version, AIRCRAFT) as fmu:
        fmu.initialise(start_s)
        t_s = start_s
        for step_s in steps:
            fmu.do_step(t_s, step_s)
            t_s += step_s
        return [fmu.get(name) for name in TRUTH]


def test_steps_and_the_version_of_fmi_change_nothing_of_the_truth():
    expected = truths(2, STEPS[0])
    for version, steps in ((2, STEPS[1]), (3, STEPS[2]), (3, [2.0])):
        np.testing.assert_allclose(truths(version, steps), expected, rtol=1e-12, atol=1e-13)  # times add up to the last bit
    assert truths(3, STEPS[0]) == expected
    drive = Vehicle(kind="aircraft", seed=5).run([2.0])
    true = np.concatenate([drive.place[0, :1], drive.velocity_n_m_s[0], drive.q_nb[0], drive.rate_b_rad_s[0]])
    np.testing.assert_allclose(expected[: len(true)], true, rtol=1e-9, atol=1e-11)


def test_far_from_zero_the_vehicle_moves_alike():
    far = truths(2, STEPS[1], 1e7)
    np.testing.assert_allclose(far, truths(2, STEPS[1]), atol=1e-6)


@versions
def test_model_exchange_flows_where_co_simulation_goes(version):
    result = fmpy.simulate_fmu(
        str(fmu_path("Vehicle", version)), fmi_type="ModelExchange", stop_time=2, output_interval=0.5, relative_tolerance=1e-8,
        start_values={"motion.kind": 1, "seed": 5}, output=TRUTH,
    )  # fmt: skip
    np.testing.assert_allclose([result[name][-1] for name in TRUTH], truths(version, STEPS[0]), rtol=1e-6, atol=1e-6)


@versions
def test_a_saved_vehicle_goes_on_as_it_would_have_gone(version):
    with opened("Vehicle", version, AIRCRAFT) as fmu:
        fmu.initialise()
        fmu.do_step(0, 1.3)
        f = fmu.fmu
        get, put, free = (
            (f.getFMUState, f.setFMUState, f.freeFMUState) if fmu.fmi3 else (f.getFMUstate, f.setFMUstate, f.freeFMUstate)
        )
        state = get()
        ends = []
        for _ in range(2):
            fmu.do_step(1.3, 0.7)
            ends.append([fmu.get(name) for name in TRUTH])
            put(state)
        free(state)
    assert ends[0] == ends[1]


# --------------------------------------------------------------------------------------------- the sensors


@pytest.mark.parametrize("name", SENSORS)
def test_noise_belongs_to_the_seed_and_the_number_of_the_sample(name):
    component = SENSORS[name]
    first = sampled(name)
    value = STATED[component][0]
    again = sampled(name, version=3)
    for output in first:
        np.testing.assert_array_equal(first[output], again[output])
    finer = sampled(name, step_s=0.05)
    same = finer[value][1::2] == first[value]
    assert same.mean() > 0.9  # a sample of the last instant may come a step sooner
    other = sampled(name, {"seed": 1})
    assert np.all(other[value][1:] != first[value][1:])


@versions
def test_a_receiver_without_errors_measures_where_its_antenna_is(version):
    antenna = [2.0, -1.0, -0.5]
    given = SILENT | {f"gnss.antenna_b_m[{i}]": value for i, value in enumerate(antenna, 1)}
    vehicle = Vehicle(kind="aircraft", seed=5)
    found = sampled("Gnss", given, 1.0, version, 0.1, vehicle)
    drive = vehicle.run(found["gnss.t_meas"])
    place = np.column_stack([found[f"gnss.{part}"] for part in ("latitude", "longitude", "height")])
    w, x, y, z = drive.q_nb.T
    R_nb = np.moveaxis(np.array([
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]), -1, 0)  # fmt: skip
    arm_e = earth.axes_at(drive.place) @ R_nb @ antenna
    np.testing.assert_allclose(earth.position_of(place), earth.position_of(drive.place) + arm_e, atol=2e-8)
    step = 1e-4  # its velocity is the derivative of its place
    before, after = (vehicle.run(found["gnss.t_meas"][3:4] + side * step) for side in (-1, 1))
    moved = [earth.position_of(d.place) + earth.axes_at(d.place) @ _rotation(d.q_nb[0]) @ antenna for d in (before, after)]
    velocity = earth.axes_at(drive.place)[3].T @ (moved[1] - moved[0])[0] / (2 * step)
    measured = [found[f"gnssvel.velocity[{i}]"][3] for i in (1, 2, 3)]
    np.testing.assert_allclose(measured, velocity, atol=1e-4)


@pytest.mark.parametrize("latitude_deg", (45, 89.999))
def test_north_and_east_of_a_velocity_are_those_of_the_measured_place(latitude_deg):
    """By a pole a fix that lies metres off has another north than the true place."""
    wrong = SILENT | {"gnss.noise_m[1]": 10.0, "gnss.noise_m[2]": 10.0}
    vehicle = Vehicle(kind="aircraft", seed=5, latitude_rad=np.radians(latitude_deg))
    found = sampled("Gnss", wrong, 2.0, vehicle=vehicle)
    drive = vehicle.run(found["gnss.t_meas"])
    place = np.column_stack([found[f"gnss.{part}"] for part in ("latitude", "longitude", "height")])
    measured = np.column_stack([found[f"gnssvel.velocity[{i}]"] for i in (1, 2, 3)])
    in_earth = np.einsum("nij,nj->ni", earth.axes_at(place), measured)
    np.testing.assert_allclose(in_earth, np.einsum("nij,nj->ni", earth.axes_at(drive.place), drive.velocity_n_m_s), atol=1e-6)


def _rotation(q_nb: np.ndarray) -> np.ndarray:
    w, x, y, z = q_nb
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * K + 2 * K @ K


def test_errors_of_the_receiver_have_the_sizes_that_its_parameters_say():
    still = Vehicle(kind="rest", sway=0, seed=1)
    many = {"gnss.period_s": 0.1, "gnss.colour_s": 1.0, "gnss.colour_m[1]": 3.0, "gnss.colour_m[2]": 0.0}
    off = []
    for seed in range(4):
        found = sampled("Gnss", many | {"seed": seed}, 50.0, vehicle=still)
        place = np.column_stack([found[f"gnss.{part}"] for part in ("latitude", "longitude", "height")])
        origin = still.run([0.0]).place
        off.append(((earth.position_of(place) - earth.position_of(origin)) @ earth.axes_at(origin)[0])[1:])
    for axis, sigma in enumerate((np.hypot(3, 0.5), np.hypot(3, 0.5), 0.5)):
        spread = np.sqrt(np.mean([o[:, axis] ** 2 for o in off]))
        assert spread == pytest.approx(sigma, rel=0.25 if axis < 2 else 0.06)
    ahead = np.mean([np.mean(o[1:, :2] * o[:-1, :2]) / 9 for o in off])  # correlated from fix to fix, as exp(-0.1 s / 1 s)
    assert ahead == pytest.approx(np.exp(-0.1), rel=0.3)


def test_an_outage_silences_and_comes_again():
    window = {"gnss.outage_start_s": 1.0, "gnss.outage_length_s": 1.0, "gnss.outage_every_s": 2.5}
    found = sampled("Gnss", SILENT | window, 5.0)
    stamps = np.unique(found["gnss.t_meas"])
    assert not np.any((stamps >= 1 - 1e-9) & (stamps < 2 - 1e-9)) and not np.any((stamps >= 3.5 - 1e-9) & (stamps < 4.5 - 1e-9))
    assert len(stamps) == 25 - 10
    inside = (found["t_s"] >= 1 - 1e-9) & (found["t_s"] < 2 - 1e-9)
    assert not found["gnss.valid"][inside].any() and found["gnss.valid"][found["t_s"] < 1 - 1e-9].all()
    assert found["gnss.valid"][np.isclose(found["t_s"], 2.3)].all()


def test_a_jump_moves_positions_within_its_window_and_nothing_else():
    jump = {"gnss.jump_start_s": 1.0, "gnss.jump_stop_s": 2.0, "gnss.jump_n_m[1]": 100.0}
    plain, moved = sampled("Gnss", SILENT), sampled("Gnss", SILENT | jump)
    north_m = (moved["gnss.latitude"] - plain["gnss.latitude"]) * 6.37e6
    inside = (plain["gnss.t_meas"] >= 1 - 1e-9) & (plain["gnss.t_meas"] < 2 - 1e-9)
    np.testing.assert_allclose(north_m[inside], 100, rtol=0.01)
    np.testing.assert_array_equal(moved["gnss.latitude"][~inside], plain["gnss.latitude"][~inside])
    # A hundred metres on north has turned by 1e-5 rad.
    np.testing.assert_allclose(moved["gnssvel.velocity[1]"], plain["gnssvel.velocity[1]"], atol=1e-3)
    np.testing.assert_array_equal(moved["gnssvel.velocity[1]"][~inside], plain["gnssvel.velocity[1]"][~inside])


def test_a_late_fix_says_when_it_was_measured_but_for_the_error_of_its_stamp():
    late = sampled("Gnss", SILENT | {"gnss.latency_s": 0.3})
    prompt = sampled("Gnss", SILENT)
    assert late["gnss.sample"][-1] == prompt["gnss.sample"][-1] - 1
    at = np.flatnonzero(np.isclose(late["gnss.t_meas"], 2.0))[0]
    assert late["t_s"][at] == pytest.approx(2.3)
    same = np.flatnonzero(np.isclose(prompt["gnss.t_meas"], 2.0))[0]
    assert late["gnss.latitude"][at] == prompt["gnss.latitude"][same]
    wrong = sampled("Gnss", SILENT | {"gnss.stamp_error_s": 0.1})
    at = np.flatnonzero(np.isclose(wrong["gnss.t_meas"], 2.1))[0]
    assert wrong["gnss.latitude"][at] == prompt["gnss.latitude"][same] and wrong["t_s"][at] == pytest.approx(2.1)


def test_outliers_have_the_given_rate():
    still = Vehicle(kind="rest", sway=0)
    found = sampled("Gnss", SILENT | {"gnss.period_s": 0.1, "gnss.outlier_probability": 0.2}, 60.0, vehicle=still)
    off = np.abs(found["gnss.height"] - 50) > 0.01
    assert 0.12 < off[1:].mean() < 0.28
    assert np.std(found["gnss.height"][off]) == pytest.approx(20, rel=0.25)


def test_pressure_falls_with_height_and_wheels_measure_the_speed_along_the_body():
    quiet = {"baro.noise_pa": 1e-6, "baro.offset_sigma_pa": 0.0, "baro.colour_pa": 0.0}
    vehicle = Vehicle(kind="aircraft", seed=5, height_m=2000)
    found = sampled("Baro", quiet, vehicle=vehicle)
    height = 44330.77 * (1 - (found["baro.pressure"] / 101325) ** 0.190263)
    np.testing.assert_allclose(height, vehicle.run(found["baro.t_meas"]).place[:, 2], atol=1e-3)
    weather = [
        sampled("Baro", quiet | {"baro.offset_sigma_pa": 500.0, "seed": seed}, 0.2, vehicle=vehicle)["baro.pressure"][0]
        for seed in range(60)
    ]
    assert np.std(weather) == pytest.approx(500, rel=0.3)
    car = Vehicle(seed=5)
    found = sampled("Wheel", {"wheel.noise_m_s": 1e-9, "wheel.scale_factor_sigma": 0.0}, vehicle=car)
    drive = car.run(found["wheel.t_meas"])
    ahead = np.array([_rotation(q)[:, 0] @ v for q, v in zip(drive.q_nb, drive.velocity_n_m_s)])
    np.testing.assert_allclose(found["wheel.speed"], ahead, atol=1e-7)
    worn = sampled("Wheel", {"wheel.noise_m_s": 1e-9, "wheel.scale_factor_sigma": 0.05}, vehicle=car)
    ratio = worn["wheel.speed"][ahead > 1] / ahead[ahead > 1]
    assert np.ptp(ratio) < 1e-6 and 1e-3 < abs(ratio[0] - 1) < 0.2
    assert sampled("Wheel", {"wheel.dropout": 1.0}, vehicle=car)["wheel.sample"][-1] == 0


@versions
def test_a_sensor_waits_for_a_truth_and_refuses_what_is_impossible(version):
    with opened("Gnss", version) as fmu:
        fmu.initialise()
        fmu.set("truth.q[1]", 0.0)
        fmu.do_step(0, 0.5)
        assert fmu.get("gnss.sample") == 0 and not fmu.get("gnss.valid")
        fmu.set("truth.q[1]", 1.0)
        fmu.do_step(0.5, 0.5)
        assert fmu.get("gnss.sample") == 1 and fmu.get("gnss.t_meas") == 0.5
    for name, parameter, value in (
        ("Baro", "baro.latency_s", 60.0),
        ("Gnss", "gnss.stamp_error_s", 9.0),
    ):
        with opened(name, version, {parameter: value}) as fmu, pytest.raises(HnavError, match=parameter.replace(".", r"\.")):
            fmu.initialise()
