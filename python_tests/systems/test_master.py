"""The master and hnav simulate: laws of sampling and order, what is stored, what is said when it fails."""

import json
import time

import numpy as np
import pytest

from command_line import hnav
from hnav.errors import HnavError, HnavValueError
from hnav.systems.master import communication_points, run_system
from hnav.systems.simulation import read_run, simulate, write_run
from hnav.systems.ssp_reader import read_system
from importing import built_fmu
from made_systems import NOISE, SENSORS, make_system, make_turntable, parameter_set
from small_files import no_longer_than

STEP_S = 0.01


@pytest.fixture(scope="module")
def needed():
    """Skips where the FMUs are not built."""
    for name in ("Turntable", "ImuMagSensor", "Hrekf", "Ahrs"):
        built_fmu(name)


@pytest.fixture
def turntable(needed, tmp_path):
    return make_turntable(tmp_path / "turntable")


def test_communication_times_are_multiples_and_the_last_does_not_pass_the_stop():
    points = communication_points(0.0, 0.3, 0.1)
    assert points.tolist() == [0.0, 0.1, 0.2, 3 * 0.1]
    assert len(communication_points(0.0, 60.0, 0.01)) == 6001
    assert communication_points(1.0, 2.05, 0.5).tolist() == [1.0, 1.5, 2.0]
    for bad in ((0.0, 1.0, 0.0), (0.0, 1.0, -1.0), (0.0, 1.0, np.nan)):
        with pytest.raises(HnavError, match="must be above 0 seconds"):
            communication_points(*bad)
    for bad in ((0.0, 0.05, 0.1), (0.0, np.inf, 0.1), (2.0, 1.0, 0.1)):
        with pytest.raises(HnavError, match="must be at least a step"):
            communication_points(*bad)


def test_half_the_step_on_the_same_samples_gives_the_same_estimates_bit_by_bit(turntable):
    runs = {step: simulate(turntable, settings=NOISE, seed=3, step_s=step, stop_s=6) for step in (STEP_S, STEP_S / 2)}
    for name in ("hekf", "hrekf", "ahrs"):
        seen = []
        for run in runs.values():
            # Each state after the samples of one time, by that time.
            values = np.column_stack(
                [
                    run[f"{name}.post.t"],
                    run.vector(name, "post.q", 4),
                    run.vector(name, "post.bias", 3),
                    run.vector(name, "post.sigma", 6),
                ]
            )
            all_used = run[f"{name}.count.gyro_used"] > 2
            seen.append({row[0]: row.tobytes() for row in values[all_used]})
        common = seen[0].keys() & seen[1].keys()
        assert len(common) > 0.95 * 6 / STEP_S
        assert all(seen[0][t] == seen[1][t] for t in common)


def test_the_order_of_the_elements_does_not_matter(needed, tmp_path):
    columns = []
    for turn, order in enumerate((("turntable", "sensor", "filter"), ("filter", "sensor", "turntable"))):
        fmus = {"turntable": "Turntable", "sensor": "ImuMagSensor", "filter": "Ahrs"}
        connections = [("turntable.truth.*", "sensor.truth.*"), *((f"sensor.{s}*", f"filter.{s}*") for s in SENSORS)]
        folder = make_system(tmp_path / str(turn), {name: fmus[name] for name in order}, connections, {"filter.sampling_mode": 1})
        columns.append(simulate(folder, settings=NOISE, seed=1, stop_s=3).columns)
    assert columns[0].keys() == columns[1].keys()
    for name, values in columns[0].items():
        np.testing.assert_array_equal(values, columns[1][name], err_msg=name)


def test_the_same_seed_gives_the_same_file_and_another_seed_another(turntable, tmp_path):
    contents = []
    for i, seed in enumerate((5, 5, 6)):
        write_run(simulate(turntable, settings=NOISE, seed=seed, stop_s=2), tmp_path / str(i))
        contents.append((tmp_path / str(i) / "signals.h5").read_bytes())
    assert contents[0] == contents[1]
    assert contents[0] != contents[2]


def test_a_closed_minute_of_three_fmus_at_100_hz_takes_less_than_3_s(needed, tmp_path):
    connections = [("turntable.truth.*", "sensor.truth.*"), *((f"sensor.{s}*", f"filter.{s}*") for s in SENSORS)]
    folder = make_system(
        tmp_path,
        {"turntable": "Turntable", "sensor": "ImuMagSensor", "filter": "Hrekf"},
        connections,
        {"filter.sampling_mode": 1},
    )
    # Processor time, the minimum of three: other load on the machine only increases it.
    seconds = []
    for _ in range(3):
        begin = time.thread_time()
        run = simulate(folder, step_s=STEP_S, stop_s=60)
        seconds.append(time.thread_time() - begin)
    assert len(run.t_s) == 6001
    assert run["filter.count.gyro_used"][-1] >= 5998
    assert min(seconds) < 3


def test_every_value_carries_the_time_at_which_it_was_put_out(turntable):
    run = simulate(turntable, stop_s=2)
    yaw = run["turntable.truth.euler[3]"]
    # The triangle begins at 0 with 10 deg/s.
    np.testing.assert_allclose(np.degrees(yaw), 10 * run.t_s, atol=1e-9)
    # Step k of the sensor samples at t_k what the turntable put out at t_k; it stands in row k + 1.
    field = run.vector("sensor", "mag.field", 3)[1:]
    np.testing.assert_allclose(field, run.vector("turntable", "truth.field", 3)[:-1], atol=1e-18)
    np.testing.assert_array_equal(run["sensor.mag.t_meas"][1:], run.t_s[:-1])


def test_inputs_of_the_system_are_held_over_the_step(needed, tmp_path):
    connections = [("heading", "filter.aid.heading"), ("good", "filter.aid.valid")]
    one = {"filter.start.start_samples": 1}
    folder = make_system(tmp_path, {"filter": "Hrekf"}, connections, one, inputs={"heading": "Real", "good": "Boolean"})
    steps = 20
    with read_system(folder) as system:
        good = np.arange(steps) < 12
        record = run_system(
            system,
            steps * STEP_S,
            STEP_S,
            ["*.count.heading_used", "*.att.euler[3]"],
            {"good": good, "heading": np.full(steps, 0.1)},
        )
        assert set(record.columns) == {"filter.count.heading_used", "filter.att.euler[3]"}
        used = record.columns["filter.count.heading_used"]
        assert used[12] == used[-1] == 12
        # The filter starts by the first heading that it gets.
        assert record.columns["filter.att.euler[3]"][1] == pytest.approx(0.1, abs=1e-12)
        with pytest.raises(HnavError, match="system made has no input height"):
            run_system(system, 1, STEP_S, inputs={"height": np.zeros(100)})
        with pytest.raises(HnavError, match=r"input heading has shape \(3,\); \(100,\) is wanted"):
            run_system(system, 1, STEP_S, inputs={"heading": np.zeros(3)})


def test_what_a_coarse_step_loses_is_counted_and_printed(turntable, tmp_path):
    run = simulate(turntable, step_s=0.05, stop_s=5)
    assert run.about["lost"]["sensor"] > 0
    done = hnav("simulate", str(turntable), "--step", "0.05", "--stop", "5", "--out", str(tmp_path / "out"))
    assert done.returncode == 0
    assert (
        f"sensor lost {run.about['lost']['sensor']} samples between the communication points: take a finer --step" in done.stdout
    )


def test_a_component_that_fails_is_named_and_the_samples_until_then_are_kept(turntable, tmp_path, monkeypatch):
    from hnav.fmi.fmus import Fmu

    step = Fmu.do_step

    def failing(self, t_s, step_s):
        if self.description.modelName == "Ahrs" and t_s >= 0.995:
            raise HnavValueError("option", "the FMU's own text")
        step(self, t_s, step_s)

    monkeypatch.setattr(Fmu, "do_step", failing)
    run = simulate(turntable, stop_s=3)
    assert run.about["failure"] == "ahrs failed the step from 1 s: the FMU's own text"
    assert run.t_s[-1] == 1.0
    assert all(len(values) == len(run.t_s) and np.isfinite(values).all() for values in run.columns.values())
    write_run(run, tmp_path)
    assert read_run(tmp_path).about["failure"] == run.about["failure"]


def test_a_parameter_that_the_fmu_refuses_is_reported_with_its_component(turntable):
    with pytest.raises(HnavError, match="^component sensor: "):
        simulate(turntable, settings={"sensor.gyro.period_s": -1.0}, stop_s=1)


def test_what_is_written_is_read(turntable, tmp_path):
    run = simulate(turntable, "gamma_off", settings={"ahrs.start.start_samples": 2}, seed=4, stop_s=1)
    write_run(run, tmp_path / "new" / "folder")
    again = read_run(tmp_path / "new" / "folder")
    assert again.about == json.loads(json.dumps(run.about))
    assert again.units == run.units
    assert again.units["sensor.mag.field[1]"] == "T"
    np.testing.assert_array_equal(again.t_s, run.t_s)
    for name, values in run.columns.items():
        assert again[name].dtype == np.float64
        np.testing.assert_array_equal(again[name], values)
    assert run.about["parameters"]["hrekf.robust.gamma_mode"] == "off"
    assert run.about["parameters"]["sensor.seed"] == 4
    assert run.components == ["turntable", "sensor", "hekf", "hrekf", "ahrs"]


def test_files_that_are_missing_or_damaged_are_named(turntable, tmp_path):
    with pytest.raises(HnavError, match="run.json: file not found; hnav simulate writes it"):
        read_run(tmp_path)
    write_run(simulate(turntable, stop_s=0.1), tmp_path)
    (tmp_path / "signals.h5").write_bytes(b"nothing")
    with pytest.raises(HnavError, match="signals.h5: cannot be read"):
        read_run(tmp_path)
    (tmp_path / "run.json").unlink()
    with pytest.raises(HnavError, match="run.json: file not found; hnav simulate writes it, and was not done here"):
        read_run(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(HnavError, match="cannot write"):
        write_run(simulate(turntable, stop_s=0.1), tmp_path / "file")


def test_a_new_run_is_not_shown_with_the_certificate_of_the_old_one(turntable, tmp_path):
    write_run(simulate(turntable, stop_s=0.1), tmp_path)
    (tmp_path / "certificate.json").write_text('{"certified": true, "reason": ""}')
    assert read_run(tmp_path).about["certificate"]["certified"]
    write_run(simulate(turntable, stop_s=0.2), tmp_path)
    assert "certificate" not in read_run(tmp_path).about
    assert not (tmp_path / "certificate.json").exists()


def test_a_full_disk_leaves_the_run_that_was_there(turntable, tmp_path):
    old, new = (simulate(turntable, stop_s=stop_s) for stop_s in (0.1, 0.2))
    out = tmp_path / "out"
    write_run(old, out)
    with no_longer_than(10_000), pytest.raises(HnavError, match="cannot write .*/signals.h5: file too large"):
        write_run(new, out)
    assert read_run(out).about == old.about and sorted(p.name for p in out.iterdir()) == ["run.json", "signals.h5"]
    np.testing.assert_array_equal(read_run(out).t_s, old.t_s)


def test_numbers_that_are_not_finite_are_kept_as_text(turntable, tmp_path):
    run = simulate(turntable, stop_s=0.1)
    run.about["parameters"]["sensor.gyro.range_rad_s"] = float("inf")
    write_run(run, tmp_path)
    assert read_run(tmp_path).about["parameters"]["sensor.gyro.range_rad_s"] == "inf"


def test_bad_input_ends_with_one_line_and_code_2(turntable, tmp_path):
    (turntable / "scenario_wrong.ssv").write_text(parameter_set({"sensor.no_such": 1.0}))
    for arguments, said in (
        (["simulate", "nothing_like_it"], "there is no system nothing_like_it"),
        (["simulate", str(tmp_path / "x.ssp")], "x.ssp: file not found"),
        (["simulate", str(turntable), "--scenario", "none"], "has no scenario none: it has gamma_off, wrong"),
        (
            ["simulate", str(turntable), "--scenario", "wrong"],
            "scenario wrong: component sensor (ImuMagSensor) has no parameter no_such",
        ),
        (["simulate", str(turntable), "--grade", "none"], "has no grade none"),
        (["simulate", str(turntable), "--set", "sensor.seed"], "write NAME=VALUE"),
        (["simulate", str(turntable), "--set", "seed=1"], "component.parameter=value is wanted"),
        (["simulate", str(turntable), "--set", "hekf.robust.gamma=x"], "hekf.robust.gamma = x: a Real is wanted"),
        (["simulate", str(turntable), "--set", "hekf.robust.gamma_mode=soft"], "one of off, fixed, relative, kl is wanted"),
        (["simulate", str(turntable), "--step", "0"], "--step 0: must be above 0 seconds"),
        (["simulate", str(turntable), "--stop", "-1"], "--stop -1: must be at least a step"),
        (["report", str(tmp_path / "none")], "none: no such file"),
        (["report", str(tmp_path)], "run.json: file not found; hnav simulate writes it"),
    ):
        done = hnav(*arguments)
        assert done.returncode == 2 and done.stdout == ""
        line = done.stderr.strip()
        assert said in line and line.startswith("hnav: ") and "\n" not in line
