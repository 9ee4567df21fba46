"""Plants that are functions in Python."""

import math
import warnings

import numpy as np
import pytest

import hnav
from hnav.errors import PlausibilityWarning
from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Row
from hnav.native.options import option_rows
from observer.test_fmu_plants import T_S, samples, spring, spring_plan


def pendulum(derivatives=lambda t, x, u, p: (x[1], -9.81 * np.sin(x[0])), outputs=lambda t, x, u, p: x[0], **more):
    plant = hnav.Plant(derivatives, outputs, states={"angle": 0.3, "rate": 0.0}, sensors=["angle"], **more)
    return Plan(plant).sensor("angle", noise=0.01).state("rate", start_sigma=0.5, noise=0.02)


def test_a_plant_shows_its_names():
    assert repr(pendulum(inputs={"torque": 0.0}).plant) == "<Plant: states angle, rate; inputs torque; sensors angle>"


def test_rows_and_calls_are_the_same_bits():
    run = Observer(spring_plan()).run(T_S, {"x": samples()}, {"u": np.sin(T_S)})
    observer = Observer(spring_plan())
    for k, t in enumerate(T_S):
        observer.push_input("u", t, np.sin(t))
        observer.push("x", t, samples()[k])
        observer.advance(t)
        estimate, sigma = observer.estimate()
        assert estimate == {name: x[k] for name, x in run.x.items()}
        assert sigma == {name: s[k] for name, s in run.sigma.items()}
        assert np.array_equal(observer.covariance(), run.covariance[k])


def test_an_unknown_input_and_a_parameter_are_learnt():
    plan = spring_plan().sensor("y", noise=0.02).unknown_input("d", start_sigma=0.5).parameter("k", start_sigma=1)
    run = Observer(plan).run(T_S, {"x": samples(k=5.0), "y": samples(2, k=5.0, offset=0.3)})
    assert list(run.x) == ["x", "v", "d", "k"]
    assert abs(run.x["k"][-1] - 5) < 4 * run.sigma["k"][-1] < 0.6
    assert abs(run.x["d"][-1] - 0.3) < 4 * run.sigma["d"][-1] < 0.1


def test_a_jacobian_is_used_when_it_is_right():
    right = Observer(pendulum(jacobian=lambda t, x, u, p: [[0, 1], [-9.81 * np.cos(x[0]), 0]]))
    wrong = Observer(pendulum(jacobian=lambda t, x, u, p: [[0, 1], [9.81 * np.cos(x[0]), 0]]))
    assert right.lies() == []
    assert "d der(rate) / d angle" in wrong.lies()[0]
    t = np.arange(0, 1, 0.1)
    a, b = (o.run(t, {"angle": 0.3 * np.cos(3 * t)}).x["rate"] for o in (right, wrong))
    assert np.abs(a - b).max() < 1e-6


def test_what_a_function_raises_is_raised_again():
    def breaks(t, x, u, p):
        if t > 0.5:
            raise ZeroDivisionError("no such place")
        return x[1], -x[0]

    observer = Observer(pendulum(breaks))
    observer.push("angle", 0.0, 0.3)
    observer.advance(0.4)
    observer.push("angle", 0.45, 0.28)
    observer.advance(0.45)
    assert observer.info().corrections == 2
    before = observer.estimate()
    with pytest.raises(ZeroDivisionError, match="no such place"):
        observer.advance(1.0)
    held, sigma = observer.estimate()
    assert np.isfinite([*held.values()]).all() and sigma["angle"] > before[1]["angle"]
    with pytest.raises(ZeroDivisionError, match="no such place"):
        observer.run(np.array([1.2]), {"angle": np.array([0.2])})


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Observer(pendulum(lambda t, x, u, p: x[1])), r"derivatives of the plant has the shape \(1,\), expected \(2,\)"),
        (lambda: Observer(pendulum(lambda t, x, u, p: None)), "derivatives of the plant answers None: it must return its values"),
        (lambda: Observer(pendulum(lambda t, x, u, p: (np.nan, 0))), r"derivatives\[0\] of the plant is nan at the start"),
        (lambda: pendulum(inputs={"rate": 0.0}), "rate is the name of two things"),
        (lambda: pendulum(parameters=["g"]), r"parameters = \[.g.\]: write names and starts"),
        (
            lambda: hnav.Plant(np.array, np.array, states={"angle": 0.0}, sensors="angle"),
            "sensors = 'angle': write a list of names",
        ),
        (
            lambda: hnav.Plant(np.array, np.array, states={"angle": 0.0}, sensors=["angle", "angle"]),
            "write a list of names, each of them once",
        ),
        (lambda: pendulum().sensor("speed", noise=1), "the plant has no sensor 'speed'; it has angle"),
        (lambda: pendulum().parameter("g", start_sigma=1), "the plant has no parameter 'g'; it has none"),
        (lambda: pendulum().input("torque"), "the plant has no input 'torque'"),
        (lambda: pendulum().set("g", 1), "the plant has no parameter 'g'"),
        (lambda: Observer(pendulum()).push("speed", 0, 0), "the plan has no sensor 'speed'; it has angle"),
        (lambda: Observer(pendulum()).run([0.0], {"speed": [0.0]}), "the plan has no sensor 'speed'"),
        (
            lambda: Observer(pendulum(inputs={"torque": 0.0}).input("torque")).run([0.0], {"torque": [0.0]}),
            "'torque' is an input of the plan, no sensor: give it by inputs=",
        ),
        (lambda: Observer(pendulum()).run([0.0], {"angle": [0.0, 1.0]}), r"angle has the shape \(2,\), expected \(1,\)"),
        (lambda: Observer(pendulum(), horizon_s=-1), "horizon_s = -1"),
    ],
)
def test_what_is_wrong_is_said(make, said):
    with pytest.raises(hnav.HnavError, match=said):
        make()


def test_parameters_that_are_not_estimated_hold_their_value():
    given = spring_plan()
    plan = given.copy().set("k", 5.0)
    assert plan.plant.parameters == {"k": 5.0} and given.plant.parameters == {"k": 4.0}
    run = Observer(plan).run(T_S, {"x": samples(k=5.0)})
    assert run.nis["x"].mean() < 2
    assert spring(0, [1, 0], [0], [5.0]) == (0, -5.0)


def test_the_observer_says_where_it_stands():
    observer = Observer(spring_plan(), horizon_s=0.1)
    info = observer.info()
    assert (info.begun, info.now_s, info.newest_s, info.events) == (False, -np.inf, -np.inf, 0)
    observer.push("x", 1.0, 0.9)
    observer.advance(1.5)
    info = observer.info()
    assert (info.begun, info.ready, info.repeatable, info.now_s, info.newest_s) == (True, False, True, 1.5, 1.0)
    assert info.late_limit_s == 0.9 and info.corrections == info.events == 1
    assert info.flow_evaluations > 0 and info.steps > 0 and info.late == info.non_finite == info.dropped == 0


def test_options_are_those_of_the_list():
    assert Observer(pendulum()).options.rtol == option_rows("observer")["rtol"].default


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"derivatives": lambda t, x, u, p: (x[1], math.sqrt(0.5 - t))}, r"\(derivatives of the plant at t = 0\.5\d* s\)"),
        ({"outputs": lambda t, x, u, p: x[0] + 0 / (t < 0.5)}, r"division by zero \(outputs of the plant at t = 0\.5 s\)"),
        ({"derivatives": lambda t, x, u, p: (x[1], np.emath.sqrt(0.5 - t))}, "derivatives of the plant answers complex numbers"),
        ({"derivatives": lambda t, x, u, p: np.array([x[1], -x[0] * 1j])}, "derivatives of the plant answers complex numbers"),
        (
            {"event": lambda t, x, u, p: x, "next_event": lambda t: max(t, 0.0)},
            "next_event of the plant answers 0 s at t = 0 s: it must be later",
        ),
        ({"event": lambda t, x, u, p: x, "next_event": lambda t: math.nan}, "next_event of the plant answers nan s"),
    ],
)
def test_what_goes_wrong_on_the_way_has_its_function_and_its_time(more, said):
    with np.errstate(all="ignore"), pytest.raises((ValueError, ZeroDivisionError), match=said):
        Observer(pendulum(**more)).run(0.1 * np.arange(10), {"angle": 0.3 * np.ones(10)})


def test_an_error_with_a_note():
    def derivatives(t, x, u, p):
        return {}["slope"]

    with pytest.raises(KeyError) as caught:
        Observer(pendulum(derivatives))
    assert "derivatives of the plant at t = 0 s" in caught.value.__notes__[0]


@pytest.mark.parametrize("smooth", [False, True])
def test_an_input_of_the_plan_without_a_sample_is_said(smooth):
    plan = pendulum(inputs={"torque": 0.0}).input("torque")
    t = 0.1 * np.arange(10)
    for inputs in (None, {"torque": np.full(10, np.nan)}):
        with pytest.warns(
            PlausibilityWarning, match="the plan samples torque, and no sample of it has come: .* give inputs={'torque': ...}"
        ):
            Observer(plan).run(t, {"angle": 0 * t}, inputs, smooth=smooth)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Observer(plan).run(t, {"angle": 0 * t}, {"torque": np.where(t == 0, 0.0, np.nan)}, smooth=smooth)
        observer = Observer(plan)
        observer.push_input("torque", 0.0, 0.1)
        observer.run(t, {"angle": 0 * t})  # it has had one


def test_rows_that_run_back_are_refused_with_the_cure():
    t = 0.1 * np.arange(10)
    with pytest.raises(hnav.HnavError, match="row 5: t_s = 0.3 s is before 0.4 s: sort the rows by it"):
        Observer(pendulum()).run(np.where(np.arange(10) == 5, 0.3, t), {"angle": 0 * t})


def test_rows_without_a_sample_do_not_begin_the_estimate():
    plant = hnav.Plant(lambda t, x, u, p: [-x[0]], lambda t, x, u, p: x[0], states={"x": 1.0}, sensors=["x"])
    plan = hnav.Plan(plant).sensor("x", noise=0.1).state("x", start_sigma=0.1)
    t, y = np.array([0.0, 1.0, 2.0]), np.array([np.nan, 1.0, np.exp(-1.0)])
    run = hnav.Observer(plan).run(t, {"x": y})
    assert np.allclose(run.x["x"], [1.0, 1.0, np.exp(-1.0)])
    given = hnav.Observer(plan, start_mode="given", start_time_s=0.0).run(t, {"x": np.full(3, np.nan)})
    assert np.allclose(given.x["x"], np.exp(-t))


def at_one_point(function):
    """The same function; it returns an array, so it is not called with Python's numbers."""
    return lambda *at: np.array(function(*at), float, ndmin=1)


@pytest.mark.parametrize("log", [False, True])
def test_functions_get_pythons_numbers_and_give_the_same(log):
    """Also with a bound and with a logarithm, and with an input that the plan omits."""

    def derivatives(t, x, u, p):
        kinds.add(type(x[0]))
        return x[1], -p[1] * x[0] - p[0] * x[1] ** 2 + u[1] + 0 * u[0]

    kinds, runs = set(), []
    for one in (derivatives, at_one_point(derivatives)):
        plant = hnav.Plant(
            one, lambda t, x, u, p: (x[1], x[0]), states={"x": 1.0, "v": 0.0}, sensors=["v", "x"],
            inputs={"a": 7.0, "b": 0.0}, parameters={"c": 0.3, "k": 4.0},
        )  # fmt: skip
        plan = hnav.Plan(plant).sensor("x", noise=0.1).input("b").state("x", start_sigma=0.1, max=1.5).state("v", noise=0.1)
        plan.parameter("k", start_sigma=0.5, log=log)
        runs.append(Observer(plan).run(T_S, {"x": samples()}, {"b": np.sin(T_S)}))
    assert kinds == {float, np.float64}
    for name in runs[0].x:
        assert runs[0].x[name] == pytest.approx(runs[1].x[name], rel=1e-9, abs=1e-12)


def test_what_pythons_numbers_cannot_do_numpys_do():
    """Functions that fail for Python's numbers, at the start or only later."""

    def fails_later(t, x, u, p):
        return x[1], -4 * x[0] + (0.0 if x[0] < 1e9 and t < 0.5 else 0 * np.float64(1) * x[0].real + 0 * (x * 0).sum())

    def of_arrays(t, x, u, p):
        assert x.shape == (2,)
        return x[1], -4 * x.copy()[0] + 0 * (2 * x)[1] + 0 * x[:1].sum()

    runs = []
    for derivatives in (lambda t, x, u, p: (x[1], -4 * x[0]), fails_later, of_arrays):
        plan = pendulum(derivatives)
        runs.append(Observer(plan).run(T_S, {"angle": 0.3 * np.cos(2 * T_S)}).x["rate"])
    assert np.allclose(runs[1], runs[0], rtol=1e-12) and np.allclose(runs[2], runs[0], rtol=1e-12)


def test_an_array_of_pythons_numbers_is_an_array():
    row = Row([1.0, 2.0, 3.0])
    a = np.array([1.0, 2.0, 3.0])
    assert [type(value) for value in (*row, row[0], row[-1])] == [float] * 5
    for found, expected in (
        (2 * row, 2 * a), (row + row, a + a), (-row, -a), (row @ row, a @ a), (np.eye(3) @ row, a), (row[1:], a[1:]), (2 * row[:2], 2 * a[:2]),
        (np.sin(row), np.sin(a)), (row.copy() * 2, 2 * a), (row > 1.5, a > 1.5), (row[[0, 2]], a[[0, 2]]), (row**2, a**2),
    ):  # fmt: skip
        assert type(found) is type(expected) and np.array_equal(found, expected)
    assert not Row([0.0])
    with pytest.raises(ValueError, match="truth value"):
        bool(row)
