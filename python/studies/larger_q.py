"""The row "EKF, larger Q" of every table of the HREKF: an EKF with a hundred times the bias walk."""

from __future__ import annotations

from typing import Any

from makers.turntable_scenarios import SCENARIOS, hrekf_parameters

NAME = "EKF, larger Q"
WALK = "gyro_bias_walk_rad_s_per_sqrt_s"
FACTOR = 100.0  # on the walk, 1e4 on Q


def larger_q(walk: float) -> dict[str, Any]:
    """Options of the hrekf. walk: the stated bias walk of the others, rad/s/sqrt(s)."""
    return {"gamma_mode": "off", "adaptation": "off", WALK: FACTOR * walk}


def in_turntable(scenario: str) -> dict[str, str]:
    """Settings by which the component hekf of the system turntable becomes this filter, for a scenario."""

    def of_hekf(options: dict[str, Any]) -> dict[str, str]:
        return {f"hekf.{name}": str(value) for name, value in hrekf_parameters(options).items()}

    (walk,) = of_hekf({WALK: 0.0})
    stated = SCENARIOS[scenario][1][walk]
    assert isinstance(stated, float)
    return of_hekf(larger_q(stated))
