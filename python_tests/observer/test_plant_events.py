"""Plants in Python with events of their own."""

import numpy as np
import pytest

import hnav
from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan


def ball(**more):
    plant = hnav.Plant(
        lambda t, x, u, p: (x[1], -9.81), lambda t, x, u, p: x[0], states={"h": 1.0, "v": 0.0}, sensors=["h"],
        indicators=lambda t, x, u, p: x[0], event=lambda t, x, u, p: (0.0, -p[0] * x[1]) if x[0] <= 0 and x[1] < 0 else x,
        parameters={"e": 0.7}, **more,
    )  # fmt: skip
    return Plan(plant).sensor("h", noise=0.02).state("h", start_sigma=0.05).state("v", start_sigma=0.3, noise=0.14)


def heater():
    plant = hnav.Plant(
        lambda t, x, u, p, q: (3 if q[0] else -3) - x, lambda t, x, u, p, q: x[0], states={"T": 0.0}, sensors=["T"],
        indicators=lambda t, x, u, p, q: 1 - x[0] if q[0] else x[0] + 1,
        event=lambda t, x, u, p, q: (x, [1 - q[0]] if (x[0] >= 1 if q[0] else x[0] <= -1) else q), discrete={"on": 1.0},
    )  # fmt: skip
    return Plan(plant).sensor("T", noise=0.02).state("T", start_sigma=0.3, noise=0.05)


def test_a_ball_bounces():
    observer = Observer(ball(), start_mode="given")
    t = np.arange(1, 15) * 0.05
    bounce, after = np.sqrt(2 / 9.81), t - np.sqrt(2 / 9.81)
    h = np.where(after < 0, 1 - 0.5 * 9.81 * t**2, 0.7 * 9.81 * bounce * after - 0.5 * 9.81 * after**2)
    run = observer.run(t, {"h": h})
    assert np.abs(run.x["h"] - h).max() < 0.01
    assert run.plant_events[0] == 0 and run.plant_events[-1] == 1
    # The sample next to the bounce does not decide whether it has occurred.
    assert run.parts[8] == 2 and run.parts[-1] == 1
    info = observer.info()
    assert (info.parts, info.largest_part, info.plant_events, info.splits) == (1, 1, 1, 1)
    assert (info.grazing, info.chattering, info.projected) == (0, 0, 0)


def test_what_a_plant_remembers_is_saved_with_the_observer():
    t = np.arange(1, 40) * 0.1
    y = np.random.default_rng(1).normal(0, 0.02, len(t)) + np.interp(t % 1.6, [0, 0.4, 1.2, 1.6], [0, 1, -1, 0])
    whole, first, second = (Observer(heater(), start_mode="given") for _ in range(3))
    expected = whole.run(t, {"T": y})
    assert expected.plant_events[-1] > 2
    first.run(t[:12], {"T": y[:12]})
    second.load(first.save())
    rest = second.run(t[12:], {"T": y[12:]})
    assert np.array_equal(rest.x["T"], expected.x["T"][12:])
    assert second.save() == whole.save()


def test_time_brings_events():
    plant = hnav.Plant(
        lambda t, x, u, p, q: q, lambda t, x, u, p, q: x[0], states={"x": 0.0}, sensors=["x"], discrete={"rate": 1.0},
        event=lambda t, x, u, p, q: (x, -q), next_event=lambda t, q: 1.0 if t < 0 else np.round(t) + 1,
    )  # fmt: skip
    observer = Observer(Plan(plant).sensor("x", noise=1).state("x", start_sigma=0.1), start_mode="given")
    for t in (0.5, 1.0, 1.75, 2.0, 3.5):
        observer.advance(t)
        assert observer.estimate()[0]["x"] == pytest.approx(1 - abs(1 - t % 2))


def test_what_an_event_raises_is_raised_again():
    def breaks(t, x, u, p):
        raise ZeroDivisionError("the floor broke")

    plan = ball()
    plan.plant.event = breaks
    observer = Observer(plan, start_mode="given")
    observer.advance(0.3)
    with pytest.raises(ZeroDivisionError, match="the floor broke"):
        observer.advance(0.6)


def test_incomplete_events_are_refused():
    with pytest.raises(hnav.HnavValueError, match="need event, which says what happens"):
        hnav.Plant(lambda t, x, u, p: x, lambda t, x, u, p: x, states={"x": 0}, sensors=["x"], indicators=lambda t, x, u, p: x)
    plan = heater()
    plan.plant.event = lambda t, x, u, p, q: (x, [0, 0])
    with pytest.raises(hnav.HnavValueError, match="discrete state after event of the plant has the shape"):
        Observer(plan, start_mode="given").advance(3)
