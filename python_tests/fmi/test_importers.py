"""The FMUs in importers that others wrote: Ecos, libcosim, fmuloader, and the checks of the FMU manipulation toolbox.

Each is an optional package: what is not installed is skipped by name. All see a level body at rest with the magnetic
heading of 30 deg: inputs at constant values, periodic sampling.
"""

import math

import fmpy
import pytest

from hnav.fmi.fmus import Fmu, fmu_path
from importing import ecos

HEADING_DEG = 30.0
VALUES = {
    "gyro.rate[1]": 0.0, "gyro.rate[2]": 0.0, "gyro.rate[3]": 0.0,
    "accel.force[1]": 0.0, "accel.force[2]": 0.0, "accel.force[3]": -9.81,
    "mag.field[1]": 2e-5 * math.cos(math.radians(HEADING_DEG)), "mag.field[2]": -2e-5 * math.sin(math.radians(HEADING_DEG)),
    "mag.field[3]": 4.5e-5,
}  # fmt: skip
versions = pytest.mark.parametrize("version", (2, 3), ids=lambda v: f"fmi{v}")


def by_fmpy(version: int) -> list[float]:
    with Fmu(fmu_path("Hrekf", version)) as fmu:
        for name, value in VALUES.items():
            fmu.set(name, value)
        fmu.initialise()
        for k in range(100):
            fmu.do_step(0.01 * k, 0.01)
        return [fmu.get(f"post.q[{i}]") for i in range(1, 5)]


def check(q: list[float], version: int) -> None:
    assert math.degrees(2 * math.atan2(q[3], q[0])) == pytest.approx(HEADING_DEG, abs=1e-6)
    assert q == pytest.approx(by_fmpy(version), abs=1e-12)


@versions
def test_ecos_runs_it(version):
    ecospy = ecos()
    structure = ecospy.EcosSimulationStructure()
    structure.add_model("filter", str(fmu_path("Hrekf", version)))
    structure.add_parameter_set("level", {f"filter::{name}": value for name, value in VALUES.items()})
    with ecospy.EcosSimulation(structure=structure, step_size=0.01) as simulation:
        simulation.init(parameter_set="level")
        simulation.step(100)
        assert simulation.get_bool("filter::align.started")
        check([simulation.get_real(f"filter::post.q[{i}]") for i in range(1, 5)], version)
        simulation.terminate()


def test_libcosim_runs_the_fmi_2_fmu():
    pytest.importorskip("libcosimpy", reason="libcosimpy is not installed")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    path = str(fmu_path("Hrekf", 2))
    references = {v.name: v.valueReference for v in fmpy.read_model_description(path).modelVariables}
    execution = CosimExecution.from_step_size(step_size=10_000_000)  # nanoseconds
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=path, instance_name="filter"))
    for name, value in VALUES.items():
        assert execution.real_initial_value(slave, references[name], value)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    assert execution.step(100)
    check(observer.last_real_values(slave, [references[f"post.q[{i}]"] for i in range(1, 5)]), 2)


@versions
def test_fmuloader_runs_it(version):
    pytest.importorskip("fmuloader", reason="fmuloader is not installed")
    path = fmu_path("Hrekf", version)
    description = fmpy.read_model_description(str(path))
    references = {v.name: v.valueReference for v in description.modelVariables}
    inputs, outputs = [references[n] for n in VALUES], [references[f"post.q[{i}]"] for i in range(1, 5)]
    folder = fmpy.extract(str(path))
    if version == 2:
        from fmuloader.fmi2 import Fmi2Slave, Fmi2Type

        slave = Fmi2Slave(folder, model_identifier="Hrekf")
        slave.instantiate("filter", Fmi2Type(1), guid=description.guid)  # 1: Co-Simulation
        slave.set_real(inputs, list(VALUES.values()))
        slave.setup_experiment(start_time=0.0)
    else:
        from fmuloader.fmi3 import Fmi3Slave

        slave = Fmi3Slave(folder, model_identifier="Hrekf")
        slave.instantiate_co_simulation("filter", instantiation_token=description.guid)
        slave.set_float64(inputs, list(VALUES.values()))
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    for k in range(100):
        slave.do_step(0.01 * k, 0.01)
    check(list(slave.get_real(outputs) if version == 2 else slave.get_float64(outputs)), version)
    slave.terminate()
    slave.free_instance()


@versions
def test_the_manipulation_toolbox_finds_nothing_to_complain_about(version, caplog):
    pytest.importorskip("fmu_manipulation_toolbox", reason="fmu-manipulation-toolbox is not installed")
    from fmu_manipulation_toolbox.checker import get_checkers
    from fmu_manipulation_toolbox.operations import FMU

    with caplog.at_level("WARNING"):
        fmu = FMU(str(fmu_path("Hrekf", version)))
        for checker in get_checkers():
            fmu.apply_operation(checker())
    complaints = [record.getMessage() for record in caplog.records if record.levelname in ("WARNING", "ERROR")]
    assert complaints == []
