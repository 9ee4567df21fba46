"""What can be estimated at all from the samples of a recording: the share of each variance that they remove, and the combinations of
states and parameters that they leave as unknown as before.

    found = observability(plan, t_s, {"x": y})
    found.share["k"], found.sentences()
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.filters.observability import Removed, joined, removed
from hnav.filters.observer import Observer, ObserverOptions
from hnav.filters.observer_plan import Plan

_BLIND = 1e6  # by which sensors are made worse, so that their samples say nothing


class Observability(Removed):
    """What the samples of an observer have removed of what was unknown."""

    def sentences(self) -> list[str]:
        """A line for each estimate, and one for each combination that is not observable."""
        lines = [f"{name}: the samples remove {100 * share:.3g} % of its variance" for name, share in self.share.items()]
        for names in self.unseen:
            if len(names) == 1:
                lines.append(f"not observable: {names[0]}; give it a smaller start_sigma, or a sensor that it acts on")
            else:
                lines.append(f"not observable: {joined(names)} together, only a combination of them; fix one, or add a sensor")
        return lines


def observability(
    plan: Plan, t_s: npt.ArrayLike, sensors: Mapping[str, npt.ArrayLike], inputs: Mapping[str, npt.ArrayLike] | None = None,
    options: ObserverOptions | None = None,
) -> Observability:  # fmt: skip
    """Of a plan and a recording, arrays as of Observer.run: two runs, one of which does not see the samples.

    Raises HnavValueError where the plant has no answer without the samples, so that there is nothing to compare with.
    """
    blind = plan.copy()
    for name, sensor in blind.sensors.items():
        blind.sensors[name] = replace(sensor, noise=_BLIND * sensor.noise, gate_nis=0.0)
    with_samples = Observer(plan, options).run(t_s, sensors, inputs)
    without = Observer(blind, options).run(t_s, sensors, inputs)
    if len(without.t_s) == 0 or without.dropped or without.held or not np.isfinite(without.covariance[-1]).all():
        raise HnavValueError(
            "option", "the plant has no answer where the samples do not correct it: begin nearer to the truth, or take fewer rows"
        )
    found = removed(plan.estimated, without.covariance[-1], with_samples.covariance[-1])
    return Observability(found.share, found.unseen)
