"""The AHRS in C beside its twin in NumPy: attitude, sigma, biases, and every verdict."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav import Filter, Options
from hnav.io.recordings import Recording
from studies.bench.motions import motion
from studies.readiness.starts import simulated_start
from twins.ahrs import AhrsReference
from twins.ahrs_parts import StillField

GATES = {"accept": "accepted", "reject": "rejected", "inflate": "inflated", "begin inflating": "inflated"}
PLAIN = dict(solver="closed_form", outlier_rate_rad_s=0.0, outlier_force_m_s2=0.0)
"""The twin has no check of outliers: after a gap a rate may lie far from the last one."""


def rows_of(recording: Recording, kept=lambda t_s: (True, True, True)) -> Iterator[tuple]:
    """Time, rate, force, field and no heading of each row; None, or no row, where kept says so."""
    for t, *samples in zip(recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla):
        if any(keeps := kept(t)):
            yield t, *(sample if keep else None for sample, keep in zip(samples, keeps)), None


def start(index: int, duration_s: float) -> Recording:
    """At rest, hand-held, walking, fast turning; in a field that is undisturbed, false at first, disturbed in passing: they take turns."""
    return simulated_start(index, 1, duration_s).recording


def push(library: Filter, t_s: float, rate, force, field, heading, speed=None) -> None:
    for name, sample in (("gyro", rate), ("accel", force), ("mag", field)):
        if sample is not None:
            getattr(library, f"push_{name}")(t_s, sample)
    if heading is not None:
        library.push_heading(t_s, *heading)
    if speed is not None:
        library.push_speed(t_s, *speed)
    library.advance(t_s)


def state_of(library: Filter) -> tuple:
    """The flags and counters, which must be equal; the numbers are compared within a tolerance."""
    now, field = library.attitude(), library.field()
    return now.tilt_ready, now.heading_ready, field.gate, field.reference_changes, field.at_rest


def state_of_twin(twin: AhrsReference) -> tuple:
    return twin.tilt_ready(), twin.heading_ready(), GATES[twin.verdict], twin.field.changes, twin.rest.at_rest()


def sigma_of(twin: AhrsReference) -> np.ndarray:
    return np.sqrt(np.diag(twin.rotation_covariance()))


def largest(difference: np.ndarray) -> float:
    return float(np.abs(difference).max())


def assert_equal(rows: Iterator[tuple], amplifies: bool = False, **options: object) -> tuple[AhrsReference, set[str]]:
    """Compares flags row by row, and in every fifth row numbers and losses too; returns the twin at the end, and every verdict on a field that
    it came to.

    amplifies: the noise of the motion depends on the sigma, and the motion may amplify roundings for seconds; a second twin that sees the
    samples one rounding larger then measures by how much.
    """
    both = Options("ahrs", **PLAIN | options)
    library, twin, verdicts = Filter(both), AhrsReference(both), set()
    rounded, room, sigma_room = AhrsReference(both), 0.0, 0.0
    for row, (t, *samples) in enumerate(rows):
        push(library, t, *samples)
        twin.event(t, *samples)
        if amplifies:
            rounded.event(t, *(s if s is None else np.nextafter(s, np.inf) for s in samples))
        if not verdicts:
            assert library.diagnostics().started == twin.started, t
        if not twin.started:
            continue
        assert state_of(library) == state_of_twin(twin), t
        verdicts.add(twin.verdict)
        if row % 5:
            continue
        now, health, q, sigma = library.attitude(), library.health(), twin.q_nb, sigma_of(twin)
        assert (health.lost, health.times_lost) == (twin.lost, twin.times_lost), t
        if amplifies:
            room, sigma_room = 100 * largest(rounded.q_nb - q), 100 * largest(sigma_of(rounded) / sigma - 1)
        assert 2 * min(largest(now.q_nb - q), largest(now.q_nb + q)) < max(1e-10, room), t
        assert largest(now.sigma_rad / sigma - 1) < max(1e-8, sigma_room), t
        assert largest(library.gyro_bias()[0] - twin.bias) < max(1e-11, 0.1 * room), t
    assert twin.started
    np.testing.assert_allclose(library.gyro_calibration()[0], twin.S, atol=max(1e-10, room))
    field, latency_room = library.field(), 100 * abs(rounded.latency - twin.latency) if amplifies else 0.0
    np.testing.assert_allclose([field.latency_s, field.evidence_s, field.heading_trust_s],
                               [twin.latency, twin.field.evidence_s, twin.field.heading_trust_s], atol=max(1e-9, latency_room))  # fmt: skip
    return twin, verdicts


@pytest.mark.parametrize("index", range(12))
def test_the_library_is_the_numpy_twin_in_every_motion_and_field(index):
    twin, verdicts = assert_equal(rows_of(start(index, 12.0 if index == 10 else 9.0)), amplifies=index in (4, 7, 8))
    if index == 1:
        assert twin.heading_ready() and not twin.field.changes
    if index == 10:
        assert twin.field.changes and verdicts == set(GATES)


def test_the_library_is_the_numpy_twin_through_gaps_and_after_long_ones():
    """Of each sensor and of all at once; the last one is too long for a body that turns fast."""

    def kept(t_s):
        return not (1 < t_s < 1.2 or 5 < t_s < 5.8), not (2 < t_s < 3.1 or 5 < t_s < 5.8), not (3 < t_s < 4 or 5 < t_s < 5.8)

    twin, _ = assert_equal(rows_of(start(7, 8.0), kept))
    assert twin.times_lost == 1 and not twin.lost


def test_the_library_is_the_numpy_twin_where_sensors_keep_their_own_times():
    def rows():
        for k, (t, rate, force, field, _) in enumerate(rows_of(start(2, 6.0))):
            yield t, rate, None, None, None
            if k % 2 == 0:
                yield t + 0.0037, None, force, None, None
            if k % 5 == 0:
                yield t + 0.0071, None, None, field, None

    for hold in ("backward", "forward", "instant"):
        assert_equal(rows(), gyro_hold=hold)


def test_the_library_is_the_numpy_twin_with_a_heading_aid_before_the_first_field():
    recording, rng = start(1, 6.0), np.random.default_rng(1)
    x = Rotation.from_quat(recording.reference_q_nb, scalar_first=True).apply([1, 0, 0])
    headings = np.arctan2(x[:, 0], x[:, 1]) + 0.02 * rng.normal(size=len(x))  # the truth is in east-north-up
    headings[300] += 1

    def rows():
        for k, row in enumerate(rows_of(recording, lambda t_s: (True, True, t_s > 4))):
            yield *row[:-1], (headings[k], 0.02) if k % 20 == 0 else None

    twin, _ = assert_equal(rows())
    assert twin.heading_ready()


@pytest.mark.parametrize("kind, seed, options", [
    ("car", 0, {}), ("car", 1, {"body": "car"}), ("aircraft", 3, {"max_speed_age_s": 1.5}), ("boat", 1, {"speed_slip_rad": 0.1}),
])  # fmt: skip
def test_the_library_is_the_numpy_twin_with_speeds_of_which_some_are_missing_or_wrong(kind, seed, options):
    recording = motion(kind, seed, "industrial").cropped(18.0)
    given = recording.aids["speed"]

    def rows():
        for k, row in enumerate(rows_of(recording)):
            second = k // 100
            wrong_m_s = 9.0 if second == 14 else 0.0
            is_there = k % 100 == 0 and second not in (4, 5, 6, 7, 8)
            yield *row, (given.values[second, 0] + wrong_m_s, given.sigma[second, 0]) if is_there else None

    twin, _ = assert_equal(rows(), **options)
    assert twin.tilt_ready() or kind == "aircraft"


@pytest.mark.parametrize("sensor", ["accel", "mag"])
def test_the_library_is_the_numpy_twin_when_first_samples_disagree(sensor):
    """The third one points elsewhere, so that the mean restarts; the first force is half of gravity."""
    recording = start(3, 3.0)
    recording.force_b_m_s2[0] *= 0.5
    samples = recording.force_b_m_s2 if sensor == "accel" else recording.field_b_tesla
    samples[2] = samples[2][[1, 2, 0]]
    assert_equal(rows_of(recording))


@pytest.mark.parametrize("options", [
    dict(gamma_mode="fixed", gamma=1.0), dict(gamma_mode="kl"), dict(gamma_mode="off"),
    dict(start_mode="heading", start_heading_rad=1.0), dict(start_mode="attitude", start_q_nb=(0.5, 0.5, -0.1, 0.3)),
    dict(start_samples=20), dict(reference_mode="given", reference_strength_tesla=4e-5), dict(output_latency_s=0.02),
], ids=lambda options: next(iter(options)) + str(next(iter(options.values()))))  # fmt: skip
def test_the_library_is_the_numpy_twin_with_other_options(options):
    assert_equal(rows_of(start(1, 3.0)), **options)


def test_the_library_is_the_numpy_twin_when_a_false_turn_loses_the_horizon_and_the_field_comes_late():
    recording = start(3, 8.0)
    recording.rate_b_rad_s[150:180] += [3.0, 0, 0]
    twin, _ = assert_equal(rows_of(recording, lambda t_s: (True, True, t_s > 3)))
    assert twin.times_lost and not twin.lost


def test_the_library_is_the_numpy_twin_when_the_reference_is_in_a_shield_at_first():
    """A field a twentieth as strong, then the earth's: it becomes the unit, however small the noise of the first is beside it."""
    recording = start(1, 10.0)
    recording.field_b_tesla[:100] *= 0.05
    twin, _ = assert_equal(rows_of(recording))
    assert twin.field.changes == 1 and twin.strength > 4e-5


@pytest.mark.parametrize("hidden, index", [(False, 0), (False, 5), (False, 10), (True, 1), (True, 3), (True, 5)])
def test_the_library_is_the_numpy_twin_with_the_field_of_the_place(hidden, index):
    simulated = simulated_start(index, 1, 10.0, hidden=hidden)
    _, north, up = simulated.earth_tesla
    twin, _ = assert_equal(rows_of(simulated.recording), reference_mode="given",
                           reference_strength_tesla=np.hypot(north, up), reference_dip_rad=np.arctan2(-up, north))  # fmt: skip
    if simulated.disturbance == "false and steady":
        assert twin.foreign2 > 0 and not twin.heading_ready() and not twin.field.changes


def test_the_library_is_the_numpy_twin_on_a_real_recording(broad_trial):
    twin, _ = assert_equal(rows_of(broad_trial.cropped(10)), outlier_rate_rad_s=8.0)
    assert twin.heading_ready()


@pytest.mark.parametrize(
    ("kind", "body", "seed", "rows"), [("car", "car", 0, 1500), ("aircraft", "aircraft", 3, 2800), ("foot", "walker", 0, 1500)]
)
def test_the_library_is_the_numpy_twin_on_a_body_that_is_given(kind, body, seed, rows, monkeypatch):
    """Stops and smooth bends, in which the field decides whether the body rests."""
    noted, note = [], StillField.note
    monkeypatch.setattr(StillField, "note", lambda self, *given: noted.append(note(self, *given)) or noted[-1])
    assert_equal(islice(rows_of(motion(kind, seed, "industrial")), rows), body=body)
    assert len(noted) > 100


def test_the_library_is_the_numpy_twin_when_the_gyro_bias_steps_at_rest():
    """By 0.4 deg/s after 8 s: the field shows that the body does not turn."""
    rng, t_s = np.random.default_rng(4), np.arange(0, 18, 0.01)
    step = np.radians([0.2, -0.3, 0.2])
    rate, force, field = (sigma * rng.standard_normal((len(t_s), 3)) for sigma in (2e-3, 0.03, 3e-7))
    rate[t_s > 8] += step
    recording = Recording("desk", t_s, rate, force + [0.3, 0.2, -9.8], field + [2e-5, 1e-6, 4.5e-5])
    twin, _ = assert_equal(rows_of(recording))
    assert np.linalg.norm(twin.bias - step) < 0.1 * np.linalg.norm(step)


@pytest.mark.parametrize(("kind", "seed", "rows"), [("car", 9, 1500), ("aircraft", 22, 1500), ("arm", 1, 3000)])
def test_the_library_is_the_numpy_twin_on_an_unknown_body_that_starts_in_motion(kind, seed, rows):
    """Readiness of the tilt waits until the velocities of a vehicle allow it, for a rest, or for a turn that no vehicle makes."""
    assert_equal(islice(rows_of(motion(kind, seed, "industrial")), rows))


@pytest.mark.parametrize(("kind", "body"), [("arm", "any"), ("quadrotor", "quadrotor")])
def test_the_library_is_the_numpy_twin_when_the_gyro_bias_steps(kind, body):
    """It steps by 1 deg/s after 20 s; both find it within 30 s, to a fifth of it."""
    recording, step = motion(kind, 0, "industrial"), np.radians([0.6, -0.6, 0.5])
    rates = recording.rate_b_rad_s + np.where(recording.t_s[:, None] - recording.t_s[0] >= 20, step, 0)
    twin, _ = assert_equal(islice(rows_of(replace(recording, rate_b_rad_s=rates)), 5000), body=body)
    before = Filter(Options("ahrs", **PLAIN, body=body))
    for row in islice(rows_of(recording), 2000):
        push(before, *row)
    assert np.linalg.norm(twin.bias - before.gyro_bias()[0] - step) < 0.2 * np.linalg.norm(step)
