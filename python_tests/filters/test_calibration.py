"""Magnetometer calibration from Python and from the command line."""

import errno
import json
import os

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from command_line import hnav
from hnav.errors import HnavError
from hnav.filters.calibration import calibrate_magnetometer
from hnav.io.readers import read
from hnav.io.sensors import read_grade, write_sensor
from studies.calibration import sphere

OFFSET_UT = np.array([12.0, -7.0, 20.0])
SOFT_IRON = np.array([[1.1, 0.04, -0.03], [0.02, 0.95, 0.05], [-0.04, 0.01, 1.02]])


def turned_about(samples: int = 500, axes: str = "all", seed: int = 3):
    """Field in uT as a distorted sensor sees it, specific force, and the true field; any attitude, or yaw alone."""
    rng = np.random.default_rng(seed)
    attitude = (
        Rotation.random(samples, rng)
        if axes == "all"
        else Rotation.from_rotvec(np.outer(rng.uniform(-np.pi, np.pi, samples), [0, 0, 1]))
    )
    truth = attitude.apply([18.0, 0, 44.0], inverse=True)
    force = attitude.apply([0, 0, -9.81], inverse=True) + 0.05 * rng.normal(size=(samples, 3))
    return truth @ SOFT_IRON.T + OFFSET_UT + 0.1 * rng.normal(size=(samples, 3)), force, truth


def write_csv(path, field, force):
    rate = np.zeros_like(field)
    table = np.column_stack([0.01 * np.arange(len(field)), rate, force, field])
    np.savetxt(path, table, delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    return path


@pytest.fixture
def tumbled(tmp_path):
    return write_csv(tmp_path / "tumbled.csv", *turned_about()[:2])


def angles_deg(a, b):
    cosine = np.einsum("ij,ij->i", a, b) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def test_the_corrected_field_points_where_the_true_one_does():
    field, force, truth = turned_about()
    found = calibrate_magnetometer(field, force, "uT")
    assert found.fit == "full" and found.note.startswith("every direction has a sample within")
    assert found.gap_rad < np.radians(20)
    np.testing.assert_allclose(found.offset, OFFSET_UT, atol=0.1)
    assert angles_deg(field, truth).mean() > 10
    assert angles_deg(found.apply(field), truth).mean() < 0.3
    assert np.degrees(found.dip_rad) == pytest.approx(np.degrees(np.arctan2(44, 18)), abs=0.2)
    np.testing.assert_allclose(np.linalg.det(found.matrix), 1, atol=1e-12)


def test_apply_takes_one_vector_and_keeps_missing_samples_missing():
    field, force, _ = turned_about()
    found = calibrate_magnetometer(field, force, "uT")
    np.testing.assert_allclose(found.apply(field[3]), found.apply(field)[3])
    assert np.isnan(found.apply(np.full((2, 3), np.nan))).all()


@pytest.mark.parametrize("unit", ["T", "uT"])
def test_a_sensor_file_corrects_as_the_calibration_does(tmp_path, unit):
    field, force, _ = turned_about()
    found = calibrate_magnetometer(field * (1e-6 if unit == "T" else 1), force, unit)
    write_sensor(tmp_path / "c.json", {"mag": found.correction})
    again = read_grade(tmp_path / "c.json").corrections["mag"]
    np.testing.assert_array_equal(again.matrix, found.matrix)
    np.testing.assert_allclose(
        again.apply(1e-6 * field),
        (1 if unit == "T" else 1e-6) * found.apply(field if unit == "uT" else 1e-6 * field),
        rtol=1e-12,
        atol=1e-18,
    )


def test_a_sensor_file_keeps_what_is_not_written(tmp_path):
    path, mine = tmp_path / "c.json", {"gyro": {"noise": {"value": 7, "unit": "mdeg/s/sqrt(Hz)"}}}
    write_sensor(path, mine, "my chip", "By hand.")
    for seed in (1, 2):
        write_sensor(path, {"mag": calibrate_magnetometer(*turned_about(seed=seed)[:2], "uT").correction}, "another")
    written, grade = json.loads(path.read_text()), read_grade(path)
    assert written["name"] == "my chip" and written["source"] == "By hand. hnav calibrate." and written["gyro"] == mine["gyro"]
    np.testing.assert_allclose(1e6 * grade.corrections["mag"].offset, OFFSET_UT, atol=0.1)
    for text in ("[1]", "{", '{"name": ""}'):
        path.write_text(text)
        with pytest.raises(HnavError, match="c.json: "):
            write_sensor(path, mine)
        assert path.read_text() == text


@pytest.mark.parametrize("change, status, named", [
    (lambda f, a: ((f[:20], a[:20]), {}), "ill-conditioned", "too few samples: 20"),
    (lambda f, a: ((f[:, :2], a), {}), "size", "field has the shape (500, 2)"),
    (lambda f, a: ((f, a[:10]), {}), "size", "force_b_m_s2 has the shape (10, 3)"),
    (lambda f, a: ((np.where(f > 60, np.inf, f), a), {}), "non-finite", "field row"),
    (lambda f, a: ((f, a), {"no_such": 1}), "option", "no_such"),
    (lambda f, a: ((f, a), {"robust": 3}), "option", "robust"),
    (lambda f, a: ((f, a), {"unit": "furlong"}), "option", "furlong"),
])  # fmt: skip
def test_bad_input_is_named(change, status, named):
    arguments, options = change(*turned_about()[:2])
    with pytest.raises(HnavError, match=named.replace("(", r"\(").replace(")", r"\)")) as caught:
        calibrate_magnetometer(*arguments, **options)
    assert caught.value.status == status


def test_a_calibration_that_cannot_be_written_whole_leaves_the_old_one(tmp_path, monkeypatch):
    found, path = calibrate_magnetometer(turned_about()[0]), tmp_path / "c.json"
    write_sensor(path, {"mag": found.correction})
    before = path.read_bytes()

    def full(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(HnavError, match="cannot write .*c.json: no space left"):
        write_sensor(path, {"accel": found.correction})
    assert path.read_bytes() == before and [file.name for file in tmp_path.iterdir()] == ["c.json"]


# --------------------------------------------------------------------------------------------- the command


def test_calibrate_prints_numbers_and_writes_file_and_picture(tmp_path, tumbled):
    out, picture = tmp_path / "c.json", tmp_path / "c.png"
    done = hnav("calibrate", tumbled, "--mag-unit", "uT", "--out", out, "--picture", picture)
    assert done.returncode == 0, done.stderr
    for word in ("offset", "uT", "matrix", "strength", "dip", "residual", "coverage"):
        assert word in done.stdout
    np.testing.assert_allclose(1e6 * read_grade(out).corrections["mag"].offset, OFFSET_UT, atol=0.1)
    assert picture.read_bytes()[:4] == b"\x89PNG" and picture.stat().st_size > 30_000


def test_filter_with_the_calibration_equals_the_filter_on_the_corrected_field(tmp_path, tumbled):
    found = tmp_path / "c.json"
    assert hnav("calibrate", tumbled, "--mag-unit", "uT", "--out", found).returncode == 0
    field, force, _ = turned_about()
    corrected = write_csv(tmp_path / "corrected.csv", 1e6 * read_grade(found).corrections["mag"].apply(1e-6 * field), force)
    tables = []
    for recording, more in ((tumbled, ["--sensor", found]), (corrected, []), (tumbled, [])):
        done = hnav("filter", recording, "--mag-unit", "uT", "--force", "--out", tmp_path / "o.csv", *more)
        assert done.returncode == 0, done.stderr
        tables.append(pd.read_csv(tmp_path / "o.csv", comment="#").to_numpy())
    np.testing.assert_allclose(tables[0], tables[1], rtol=1e-6, atol=1e-6, equal_nan=True)
    assert not np.allclose(tables[0][:, 1:5], tables[2][:, 1:5], atol=1e-2, equal_nan=True)


def test_yaw_alone_is_refused_and_hard_iron_only_says_so(tmp_path):
    recording = write_csv(tmp_path / "yaw.csv", *turned_about(axes="yaw")[:2])
    done = hnav("calibrate", recording, "--mag-unit", "uT")
    assert done.returncode == 2
    assert "one axis only" in done.stderr and "--allow-hard-iron-only" in done.stderr and "for --sensor FILE.json" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    done = hnav("calibrate", recording, "--mag-unit", "uT", "--allow-hard-iron-only")
    assert done.returncode == 0, done.stderr
    assert "hard iron only, in the plane" in done.stdout


@pytest.mark.parametrize("arguments, named", [
    (["calibrate", "nowhere.csv"], "nowhere.csv"),
    (["calibrate", "TUMBLED", "--mag-unit", "furlong"], "furlong"),
    (["calibrate", "TUMBLED", "--out", "/nonexistent/c.json"], "/nonexistent/c.json"),
    (["calibrate", "TUMBLED", "--picture", "OUT.nothing"], "OUT.nothing"),
    (["calibrate", "BARE"], "no magnetometer"),
    (["filter", "TUMBLED", "--out", "OUT", "--sensor", "nowhere.json"], "nowhere.json"),
])  # fmt: skip
def test_what_cannot_be_done_is_one_line_and_exit_code_2(tmp_path, tumbled, arguments, named):
    bare = tmp_path / "bare.csv"
    bare.write_text("t_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,9.81\n0.01,0,0,0,0,0,9.81\n")
    places = {
        "TUMBLED": str(tumbled),
        "BARE": str(bare),
        "OUT": str(tmp_path / "o.csv"),
        "OUT.nothing": str(tmp_path / "OUT.nothing"),
    }
    done = hnav(*(places.get(a, a) for a in arguments))
    assert done.returncode == 2
    assert named in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr


# --------------------------------------------------------------------------------------------- real recordings


def test_on_broad_the_residual_never_grows_and_refusals_say_why(broad_trials):
    answers, some = 0, list(broad_trials.values())[::2]
    for path in some:
        data = read(path)
        try:
            found = calibrate_magnetometer(data.field_b_tesla, data.force_b_m_s2, allow_hard_iron_only=1)
        except HnavError as error:
            assert error.status == "ill-conditioned"
            continue
        answers += 1
        assert found.residual_after <= found.residual_before
        assert 35e-6 < found.strength < 60e-6
        assert 60 < np.degrees(found.dip_rad) < 75
    assert answers >= len(some) // 2


def direction_error_deg(seen: np.ndarray, truth: np.ndarray) -> float:
    """Root mean square angle after the best common rotation, which the mounting of the optical markers leaves open."""
    seen = seen / np.linalg.norm(seen, axis=1, keepdims=True)
    best, _ = Rotation.align_vectors(truth, seen)
    return float(np.sqrt(np.mean(angles_deg(best.apply(seen), truth) ** 2)))


def test_every_full_fit_on_broad_is_nearer_to_optical_truth_than_the_sensor_as_it_is(broad_trials):
    true, improved = sphere(), 0
    for number, path in broad_trials.items():
        data = read(path)
        try:
            found = calibrate_magnetometer(data.field_b_tesla * 1e6, data.force_b_m_s2, "uT")
        except HnavError:
            continue
        # The sensor's true distortion: field = D R' m_n + o by least squares, R from the cameras.
        known = np.isfinite(data.reference_q_nb).all(axis=1)
        attitude = Rotation.from_quat(data.reference_q_nb[known][:, [1, 2, 3, 0]])
        field = data.field_b_tesla[known] * 1e6
        true_field = attitude.apply(np.median(attitude.apply(field), axis=0), inverse=True)
        affine, *_ = np.linalg.lstsq(np.column_stack([true_field, np.ones(len(field))]), field, rcond=None)
        measured = found.strength * true @ affine[:3] + affine[3]
        before, after = direction_error_deg(measured, true), direction_error_deg(found.apply(measured), true)
        print(f"trial {number:02d}: residual {100 * found.residual_before:.2f} -> {100 * found.residual_after:.2f} %,"
              f" direction error over the sphere {before:.2f} -> {after:.2f} deg, stated {np.degrees(found.direction_sigma_rad):.2f}")  # fmt: skip
        assert after < before
        improved += 1
    assert improved >= 3
