"""The SSP system observer: a plant of ours and the FMU that estimates its states, run by fmpy, by Ecos and by a loop of our own."""

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

from checkout import TOP, built_system
from command_line import hnav
from hnav.filters.observer import Observer
from hnav.filters.observer_plan import read_plan
from hnav.fmi.fmus import fmu_path
from importing import assert_fits_the_standard, ecos
from makers.observer import write_system
from systems.test_systems import bound_parameters

FOLDER = TOP / "models" / "systems" / "observer"


@pytest.fixture(scope="module")
def ssp() -> str:
    return built_system("observer")


@pytest.fixture(scope="module")
def seen(ssp) -> np.ndarray:
    """20 s at the sensor's period, by fmpy."""
    return simulate_ssp(ssp, stop_time=20, step_size=0.02, parameter_set=bound_parameters(ssp))


def test_the_files_in_the_repository_are_those_that_plan_and_fmus_give(tmp_path):
    """After ./run fmus, `python -m makers.observer models/systems/observer` writes them."""
    write_system(tmp_path, FOLDER)
    written = {str(p.relative_to(tmp_path)): p.read_text() for p in tmp_path.rglob("*.*")}
    kept = {str(p.relative_to(FOLDER)): p.read_text() for p in FOLDER.rglob("*.*") if p.name not in ("plan.toml", "README.md")}
    assert sorted(written) == sorted(kept)
    for name in written:
        assert written[name] == kept[name], name


@pytest.mark.parametrize("version", (2, 3))
@pytest.mark.parametrize("name", ("Pendulum", "Observer"))
def test_the_fmus_fit_the_standard(name, version):
    assert_fits_the_standard(fmu_path(name, version), version)


def test_the_estimate_is_the_truth_within_its_sigma(ssp, seen):
    read_ssd(ssp, validate=True)
    late = seen["time"] > 2
    for name in ("angle", "rate"):
        error = seen[f"observer.est.{name}"] - seen[f"pendulum.truth.{name}"]
        assert np.abs(error[1]) > 0
        # 99.9 % of independent values lie within 3.3 sigma; these hang together.
        assert np.mean(np.abs(error[late]) < 3.3 * seen[f"observer.sigma.{name}"][late]) > 0.99
    assert seen["observer.ready"][late].all() and not seen["observer.ready"][1]
    assert seen["observer.count.angle.used"][-1] == 1000 and seen["observer.count.missed"][-1] == 0
    assert 0.6 < seen["observer.mean_nis.angle"][-1] < 1.6


def test_it_is_the_observer_of_the_plan_bit_for_bit(seen):
    """The samples of the plant's sensor, filtered again by the library."""
    observer = Observer(read_plan(FOLDER / "plan.toml", fmu_path("Pendulum", 2)))
    stamps, first = np.unique(seen["pendulum.measured.t_meas"], return_index=True)
    run = observer.run(stamps, {"angle": seen["pendulum.measured.value"][first]})
    shown = [int(np.flatnonzero(seen["observer.post.t"] == t)[0]) for t in stamps[5:-2]]
    for name in ("angle", "rate"):
        assert np.array_equal(seen[f"observer.post.{name}"][shown], run.x[name][5:-2])


def test_ecos_runs_it(ssp, seen):
    ecospy = ecos()
    with ecospy.EcosSimulation(ssp_path=ssp, step_size=0.02) as simulation:
        simulation.init()
        simulation.step(500)
        assert simulation.get_integer("observer::count.angle.used") > 490
        truth, shown, sigma = (
            simulation.get_real(name) for name in ("pendulum::truth.rate", "observer::est.rate", "observer::sigma.rate")
        )
        assert abs(shown - truth) < 4 * sigma
        simulation.terminate()


def test_the_command_runs_it(ssp, tmp_path):
    done = hnav("simulate", "observer", "--stop", 2, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "run" / "signals.h5").is_file()
