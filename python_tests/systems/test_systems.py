"""The SSP systems: valid, and run by fmpy and Ecos."""

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import ParameterSet, read_ssd

from checkout import built_system
from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions
from hnav.simulation.aircraft import AircraftPlant
from hnav.systems.aircraft import models_folder, read_aircraft
from importing import ecos

LEVEL = {"accel.force[3]": -9.81, "mag.field[1]": 2e-5, "mag.field[3]": 4.5e-5}


SYSTEMS = {
    "filter": {"hekf", "hrekf"},
    "aircraft": {
        f"{name}_{motion}" for name in ("aircraft", "mdkf", "amdkf", "augmented") for motion in ("longitudinal", "lateral")
    },
}
SEEDS = {"longitudinal": 1, "lateral": 2}  # as the system binds them


def bound_parameters(path: str) -> ParameterSet:
    """The parameter bindings of the components, as simulate_ssp wants them: it does not read them itself."""
    parameters = ParameterSet(name="bound")
    for element in read_ssd(path).system.elements:
        for binding in element.parameterBindings:
            for values in binding.parameterValues:
                for parameter in values.parameters:
                    parameter.name = f"{element.name}.{parameter.name}"
                    parameters.parameters.append(parameter)
    return parameters


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_structure_is_valid_and_every_connection_has_its_connectors(name):
    system = read_ssd(built_system(name), validate=True).system
    connectors = {("", c.name) for c in system.connectors}
    connectors |= {(element.name, c.name) for element in system.elements for c in element.connectors}
    for connection in system.connections:
        assert (connection.startElement or "", connection.startConnector) in connectors
        assert (connection.endElement or "", connection.endConnector) in connectors
    assert {element.name for element in system.elements} == SYSTEMS[name]


def test_fmpy_runs_the_filters_of_attitude():
    constant = {name: (lambda t, value=value: value) for name, value in LEVEL.items()}
    result = simulate_ssp(built_system("filter"), stop_time=1, step_size=0.01, input=constant)
    for name in ("hekf", "hrekf"):
        column = f"{name}.att.q[1]"
        assert column in result.dtype.names, result.dtype.names
        assert result[column][-1] == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("motion", SEEDS)
def test_fmpy_runs_the_aircraft_and_its_three_filters_as_the_library_does(motion):
    path = built_system("aircraft")
    # 160 steps; fmpy adds up, and a stop at 16 s may come one step late.
    result = simulate_ssp(path, stop_time=15.95, step_size=0.1, parameter_set=bound_parameters(path))
    aircraft = read_aircraft(models_folder() / f"f4c_{motion}.json")
    plant = AircraftPlant(aircraft, seed=SEEDS[motion])
    flight = plant.run(161)
    # fmpy makes the first step before it connects anything: the filters begin with sample 1, and end with sample 159.
    seen = slice(1, 160)
    for form in ("mdkf", "amdkf", "augmented"):
        run = InsErrorFilter(plant.filter_model(), InsErrorOptions(form=form)).run(flight.u[seen], flight.z[seen])
        for i, channel in enumerate(aircraft.channels):
            assert result[f"{form}_{motion}.estimate.{channel.name}"][-1] == run.x[-1, i], (form, channel.name)
        assert result[f"{form}_{motion}.count.samples"][-1] == 159 and result[f"{form}_{motion}.count.missed"][-1] == 0
    np.testing.assert_array_equal([result[f"aircraft_{motion}.truth.{c.name}"][-1] for c in aircraft.channels], flight.x[160])


@pytest.mark.parametrize("motion", SEEDS)
def test_ecos_runs_the_aircraft_and_its_filters(motion):
    """Ecos cannot set enumerations: its filters stay augmented and sample by period."""
    ecospy = ecos()
    aircraft = read_aircraft(models_folder() / f"f4c_{motion}.json")
    plant = AircraftPlant(aircraft, seed=SEEDS[motion])
    flight = plant.run(100)
    run = InsErrorFilter(plant.filter_model()).run(flight.u, flight.z)
    with ecospy.EcosSimulation(ssp_path=built_system("aircraft"), step_size=0.1) as simulation:
        simulation.init(parameter_set="parameters")
        simulation.step(100)
        assert simulation.get_integer(f"augmented_{motion}::count.samples") == 100
        assert [simulation.get_real(f"augmented_{motion}::estimate.{c.name}") for c in aircraft.channels] == run.x[-1].tolist()
        simulation.terminate()
