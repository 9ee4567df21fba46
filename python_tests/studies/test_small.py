"""The small build on a Cortex-M4F in qemu beside this machine: the same answers, within the sizes that its page promises."""

import os

import numpy as np
import pytest

from studies.counting import write_samples
from studies.small.study import (
    CONTENDERS,
    WORK,
    Contender,
    code_bytes,
    largest_angle_deg,
    missing_tools,
    replay_here,
    replay_in_qemu,
)

ROWS = 3000  # 10 s
MAX_BYTES = {"float": 12 * 1024, "double": 24 * 1024}  # of a filter
OWN = [c for c in CONTENDERS if c.own]


def turning_samples() -> np.ndarray:
    """As write_samples has them, of a level body that turns back and forth about all axes a little."""
    t_s = np.arange(ROWS) / 286
    noise = np.random.default_rng(3).normal(size=(3, ROWS, 3)) * np.array([1e-3, 0.02, 2e-7])[:, None, None]
    tilt = 0.2 * np.sin(0.8 * t_s)
    rate = np.stack([0.16 * np.cos(0.8 * t_s), 0 * t_s, 0 * t_s], 1) + noise[0]
    force = 9.80665 * np.stack([0 * t_s, -np.sin(tilt), -np.cos(tilt)], 1) + noise[1]
    field = np.stack([2e-5 + 0 * t_s, 4.4e-5 * np.sin(tilt), 4.4e-5 * np.cos(tilt)], 1) + noise[2]
    return np.concatenate([t_s, rate.ravel(), force.ravel(), field.ravel()])


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    file = tmp_path_factory.mktemp("small") / "samples.bin"
    if "BROAD_DIR" in os.environ:
        write_samples(file, ROWS)
    else:
        file.write_bytes(turning_samples().tobytes())
    WORK.mkdir(parents=True, exist_ok=True)
    return file


def test_the_angle_between_attitudes_is_that_of_the_turn():
    half = np.radians(30) / 2
    turned, other = np.array([[np.cos(half), 0, np.sin(half), 0]]), np.array([[1.0, 0, 0, 0]])
    assert largest_angle_deg(turned, other) == pytest.approx(30)
    assert largest_angle_deg(turned, -turned) == pytest.approx(0, abs=1e-6)


@pytest.mark.slow  # builds the filters for the processor: a minute or two
@pytest.mark.skipif(bool(missing_tools()), reason=f"this machine has no {', '.join(missing_tools())}: see docs/embedded.md")
@pytest.mark.parametrize("contender", OWN, ids=lambda c: f"{c.own}-{c.scalar}")
def test_a_processor_answers_as_this_machine_does(contender, samples):
    there, memory, stack = replay_in_qemu(contender, samples, ROWS)
    here = replay_here(Contender(contender.label, "double", own=contender.own), samples, ROWS)
    assert np.isfinite(there).all()
    assert np.linalg.norm(there[-1]) == pytest.approx(1, abs=1e-6)
    if contender.scalar == "double":
        assert np.abs(there - here).max() < 1e-8  # 2e-9 was found for the AHRS, 2e-15 for the HREKF
    else:
        assert largest_angle_deg(there, here) < 0.05
        assert code_bytes(contender) <= 64 * 1024
        assert 0 < stack <= 8 * 1024
    assert 1000 < memory <= MAX_BYTES[contender.scalar]
