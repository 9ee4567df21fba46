"""The simulated aircraft of the C library against the NumPy simulator on equal noise, and the errors that a Python caller gets."""

import numpy as np
import pytest

from aircraft_noise import STREAMS, normal_numbers
from hnav.errors import HnavError
from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions
from hnav.filters.linear_model import MATRICES
from hnav.simulation.aircraft import AircraftPlant
from hnav.systems.aircraft import models_folder, read_aircraft
from twins.aircraft import fly, model_of

AXES = ("f4c_longitudinal", "f4c_lateral")
STEPS = 300


def aircraft_of(axis: str):
    return read_aircraft(models_folder() / f"{axis}.json")


@pytest.mark.parametrize("exact", [False, True], ids=["sampled noise", "exact noise"])
@pytest.mark.parametrize("euler", [False, True], ids=["exact colour", "printed colour"])
@pytest.mark.parametrize("axis", AXES)
def test_the_library_flies_as_the_numpy_simulator_on_equal_noise(axis, euler, exact):
    aircraft = aircraft_of(axis)
    n, seed = len(aircraft.channels), 5
    numbers = {s: normal_numbers(seed, stream, (STEPS + 1) * n).reshape(-1, n) for s, stream in STREAMS.items()}
    model = model_of(aircraft, euler_colour=euler, sampled_noise=not exact)
    numpy = fly(aircraft, STEPS, lambda source, k: numbers[source][k][None], model)
    flight = AircraftPlant(aircraft, seed, euler_colour=euler, exact_process_noise=exact).run(STEPS + 1)
    for name, expected in dict(x=numpy.x[0], z=numpy.z[0], u=numpy.u, noise_factor=numpy.noise_factor).items():
        value = getattr(flight, name)
        assert np.abs(value - expected).max() <= 1e-10 * max(1, np.abs(expected).max()), name
    assert np.ptp(flight.lam, axis=0).min() > 0


@pytest.mark.parametrize("exact", [False, True], ids=["sampled noise", "exact noise"])
@pytest.mark.parametrize("euler", [False, True], ids=["exact colour", "printed colour"])
@pytest.mark.parametrize("axis", AXES)
def test_its_filter_model_is_that_of_the_model_file(axis, euler, exact):
    aircraft = aircraft_of(axis)
    expected = model_of(aircraft, euler_colour=euler, sampled_noise=not exact).discrete()
    model = AircraftPlant(aircraft, euler_colour=euler, exact_process_noise=exact).filter_model().discrete()
    for name in MATRICES:
        np.testing.assert_allclose(getattr(model, name), getattr(expected, name), rtol=1e-10, atol=1e-14, err_msg=name)


def test_a_second_coloured_error_adds_to_the_first():
    aircraft = aircraft_of("f4c_longitudinal")
    alone = AircraftPlant(aircraft, 2).run(100)
    both = AircraftPlant(aircraft, 2, gravity_sigma=np.full(4, 0.1), gravity_time_constant_s=np.full(4, 200.0)).run(100)
    np.testing.assert_array_equal(both.x, alone.x)
    first = 0.1 * normal_numbers(2, STREAMS["gravity"], 4)
    np.testing.assert_allclose(both.lam[0] - alone.lam[0], first, atol=1e-12)
    with pytest.raises(HnavError, match="gravity_error.time_constant_s"):
        AircraftPlant(aircraft, gravity_sigma=np.full(4, 0.1))


def test_without_controls_and_faults_it_flies_straight_and_healthy():
    aircraft = aircraft_of("f4c_longitudinal")
    flight = AircraftPlant(aircraft, controls=False, faults=False).run(200)
    assert not flight.u.any() and (flight.noise_factor == 1).all()
    steered = AircraftPlant(aircraft, controls=False, faults=False).run(200, np.full((200, 1), 0.01))
    assert (steered.u[1:] == 0.01).all() and steered.u[0] == 0


def test_a_saved_flight_goes_on_bit_for_bit():
    plant = AircraftPlant(aircraft_of("f4c_lateral"), 3)
    first = plant.run(40)
    state = plant.save()
    straight = plant.run(40)
    plant.load(state)
    np.testing.assert_array_equal(plant.run(40).z, straight.z)
    plant.reset()
    np.testing.assert_array_equal(plant.run(40).z, first.z)
    with pytest.raises(HnavError, match="saved by another aircraft"):
        AircraftPlant(aircraft_of("f4c_lateral"), 4).load(state)


def test_the_augmented_filter_finds_the_fault_of_the_flight():
    plant = AircraftPlant(aircraft_of("f4c_longitudinal"), 1)
    flight = plant.run(201)
    run = InsErrorFilter(plant.filter_model(), InsErrorOptions()).run(flight.u, flight.z)
    q, theta = run.fault_probability[:, 2], run.fault_probability[:, 3]
    assert q[80:150].mean() > 0.9 and theta[80:150].mean() > 0.8
    assert max(q[30:80].mean(), theta[30:80].mean()) < 0.1
