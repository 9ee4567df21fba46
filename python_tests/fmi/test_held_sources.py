"""A sensor that is slower than the period of its input: the importer holds its values, and each is one sample."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav.fmi.fmus import Fmu, fmu_path
from motion import readings, turning

STEP_S, SECONDS = 0.01, 60


def driven(hold):
    """Errors of the attitude by their sigmas, n x 3, while the heading is ready after 15 s, and the log, of an Ahrs whose inputs
    are held for so many steps."""
    samples, hold_s = readings(np.arange(0, SECONDS, STEP_S * hold)), STEP_S * hold
    found = []
    with Fmu(fmu_path("Ahrs", 2)) as fmu:
        fmu.initialise(0.0)
        for k in range(round(SECONDS / STEP_S)):
            if k % hold == 0:
                for name, values in zip(("gyro.rate", "accel.force", "mag.field"), samples):
                    for axis in range(3):
                        fmu.set(f"{name}[{axis + 1}]", float(values[k // hold][axis]))
            fmu.do_step(k * STEP_S, STEP_S)
            if k % 10 or k * STEP_S < 15 or not fmu.get("align.heading_ready"):
                continue
            q = [fmu.get(f"att.q[{i}]") for i in (2, 3, 4, 1)]
            sampled_s = k // hold * hold_s
            error = (turning(np.array([sampled_s]))[0] * Rotation.from_quat(q).inv()).as_rotvec()
            found.append(error / [fmu.get(f"att.sigma[{i + 1}]") for i in range(3)])
        said = list(fmu.messages)
    return np.array(found), said


@pytest.mark.parametrize("hold", [1, 2, 5, 10])
def test_values_that_repeat_are_one_sample(hold):
    errors, said = driven(hold)
    assert len(errors) > 50 and np.mean(abs(errors) > 3) < 0.01, np.max(abs(errors), axis=0)
    repeats = [line for line in said if "repeat" in line]
    if hold == 1:
        assert not repeats
    else:
        (line,) = repeats
        assert f"period of the source, {STEP_S * hold:g} s" in line and ".period" in line


def test_a_constant_input_is_a_sample_at_each_period():
    """A simulation at rest without noise, and then with rates that change in steps: nothing is held there."""
    with Fmu(fmu_path("Ahrs", 2)) as fmu:
        fmu.initialise(0.0)
        for k in range(3000):
            fmu.set("gyro.rate[3]", 0.0)
            fmu.do_step(k * STEP_S, STEP_S)
        at_rest = fmu.get("count.corrections")
        turned = 0.0
        for k in range(3000, 6000):
            rate = [0.0, 0.3, 0.0, -0.2][k // 50 % 4]
            turned += rate * STEP_S
            down = Rotation.from_euler("x", turned)
            for axis, (w, f) in enumerate(zip((rate, 0, 0), down.apply([0, 0, -9.80665], inverse=True))):
                fmu.set(f"gyro.rate[{axis + 1}]", float(w))
                fmu.set(f"accel.force[{axis + 1}]", float(f))
            fmu.do_step(k * STEP_S, STEP_S)
        assert not [line for line in fmu.messages if "repeat" in line]
        assert at_rest > 500 and fmu.get("count.corrections") > 1.9 * at_rest


def test_a_source_that_stands_still_is_sampled_again():
    """Held values that stop changing are those of a body at rest in a simulation without noise."""
    samples = readings(np.arange(0, 10, 0.1), noise=1)
    with Fmu(fmu_path("Ahrs", 2)) as fmu:
        fmu.initialise(0.0)
        counts = []
        for k in range(2000):
            for name, values in zip(("gyro.rate", "accel.force", "mag.field"), samples):
                for axis in range(3):
                    fmu.set(f"{name}[{axis + 1}]", float(values[min(k // 10, 99)][axis]))
            fmu.do_step(k * STEP_S, STEP_S)
            counts.append(fmu.get("count.corrections"))
        while_held, after = counts[999] - counts[499], counts[1999] - counts[1499]
        assert while_held < 60 and after > 100
