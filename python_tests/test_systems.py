"""The SSP systems: valid, and run by fmpy."""

import os
from pathlib import Path

import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

BUILD = Path(os.environ.get("HNAV_BUILD", Path(__file__).resolve().parents[1] / "build"))
LEVEL = {"accel.force[3]": -9.81, "mag.field[1]": 2e-5, "mag.field[3]": 4.5e-5}


@pytest.fixture(scope="module")
def ssp() -> str:
    path = BUILD / "ssp" / "filter.ssp"
    if not path.is_file():
        pytest.skip(f"{path} is not built")
    return str(path)


def test_the_structure_is_valid_and_every_connection_has_its_connectors(ssp):
    system = read_ssd(ssp, validate=True).system
    connectors = {("", c.name) for c in system.connectors}
    connectors |= {(element.name, c.name) for element in system.elements for c in element.connectors}
    for connection in system.connections:
        assert (connection.startElement or "", connection.startConnector) in connectors
        assert (connection.endElement or "", connection.endConnector) in connectors
    assert {element.name for element in system.elements} == {"hekf", "hrekf"}


def test_fmpy_runs_the_system(ssp):
    constant = {name: (lambda t, value=value: value) for name, value in LEVEL.items()}
    result = simulate_ssp(ssp, stop_time=1, step_size=0.01, input=constant)
    for name in ("hekf", "hrekf"):
        column = f"{name}.att.q[1]"
        assert column in result.dtype.names, result.dtype.names
        assert result[column][-1] == pytest.approx(1, abs=1e-9)
