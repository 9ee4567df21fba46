"""Unobservable numbers are named, single ones and combinations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hnav.filters.observability import removed
from hnav.filters.observer_observability import Observability, observability
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant

T_S = np.arange(0.1, 10.0, 0.1)


def tank() -> Plan:
    """The level falls with k sqrt(h) / area: only the quotient of k and area is observable."""
    plant = Plant(
        lambda t, x, u, p: [-p[0] * math.sqrt(max(x[0], 1e-9)) / p[1]], lambda t, x, u, p: [x[0]], states={"h": 4.0}, sensors=["h"],
        parameters={"k": 0.2, "area": 1.0},
    )  # fmt: skip
    return (
        Plan(plant)
        .sensor("h", noise=0.01)
        .state("h", start_sigma=0.2)
        .parameter("k", start_sigma=0.02)
        .parameter("area", start_sigma=0.1)
    )


def two_rooms(sensor: str) -> Plan:
    """Two rooms without heat exchange."""
    plant = Plant(
        lambda t, x, u, p: [-0.2 * x[0], -0.3 * x[1]], lambda t, x, u, p: [x[0] if sensor == "one" else x[0] + x[1]],
        states={"one": 1.0, "two": 2.0}, sensors=[sensor],
    )  # fmt: skip
    return Plan(plant).sensor(sensor, noise=0.01).state("one", start_sigma=0.3).state("two", start_sigma=0.5)


def drift() -> Plan:
    """A velocity sensor beside a position that is not measured, with the offset of the sensor."""
    plant = Plant(
        lambda t, x, u, p: [x[1], -x[1] + 1], lambda t, x, u, p: [x[1] + p[0]], states={"s": 0.0, "v": 0.0}, sensors=["v"],
        parameters={"offset": 0.0},
    )  # fmt: skip
    return (
        Plan(plant)
        .sensor("v", noise=0.01)
        .state("s", start_sigma=5.0)
        .state("v", start_sigma=0.5)
        .parameter("offset", start_sigma=0.2)
    )


def found(plan: Plan, y) -> Observability:
    return observability(plan, T_S, {next(iter(plan.sensors)): y})


def test_a_quotient_hides_its_parts():
    h = (2 - 0.1 * T_S) ** 2
    seen = found(tank(), h)
    assert [set(names) for names in seen.unseen] == [{"k", "area"}]
    assert seen.share["h"] > 0.9 and "not observable: k and area together" in "\n".join(seen.sentences())


def test_what_no_sensor_sees_is_named():
    assert found(two_rooms("one"), np.exp(-0.2 * T_S)).unseen == (("two",),)


def test_a_position_that_is_not_measured():
    assert found(drift(), 1 - np.exp(-T_S)).unseen == (("s",),)


@pytest.mark.parametrize("plan", ["both", "mass"])
def test_what_is_observable_is_not_named(plan):
    if plan == "both":
        seen = found(two_rooms("both"), np.exp(-0.2 * T_S) + 2 * np.exp(-0.3 * T_S))
    else:
        plant = Plant(
            lambda t, x, u, p: [x[1], -p[0] * x[0]], lambda t, x, u, p: [x[0]], states={"x": 1.0, "v": 0.0}, sensors=["x"],
            parameters={"k": 4.0},
        )  # fmt: skip
        known = (
            Plan(plant)
            .sensor("x", noise=0.01)
            .state("x", start_sigma=0.1)
            .state("v", start_sigma=0.1)
            .parameter("k", start_sigma=0.2)
        )
        seen = found(known, np.cos(2 * T_S))
    assert seen.unseen == () and min(seen.share.values()) > 0.9


def test_three_that_share_two_unseen_directions():
    prior = np.diag([4.0, 1.0, 9.0])
    h = np.array([1.0, 1.0, 0.0])
    gain = prior @ h / (h @ prior @ h + 1e-6)
    seen = removed(("a", "b", "c"), prior, prior - np.outer(gain, h @ prior))
    assert sorted(sorted(names) for names in seen.unseen) == [["a", "b"], ["c"]]
    assert seen.share["c"] == pytest.approx(0, abs=1e-9) and seen.share["a"] == pytest.approx(0.8, abs=1e-3)
