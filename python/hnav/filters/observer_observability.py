"""What can be estimated at all from the samples of a recording: the share of each variance that they remove, and the combinations of
states and parameters that they leave as unknown as before.

    found = observability(plan, t_s, {"x": y})
    found.share["k"], found.sentences()
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.filters.observer import Observer, ObserverOptions
from hnav.filters.observer_plan import Plan
from hnav.native.arrays import Array

UNSEEN = 0.9  # share of a variance that is left: less than a tenth was removed
_BLIND = 1e6  # by which sensors are made worse, so that their samples say nothing
_PART = 0.2  # of the largest component, that makes another one part of a combination
_SINGULAR = 1e-9  # of the largest variance: no direction of its own


@dataclass(frozen=True)
class Observability:
    """What the samples have removed of what was unknown."""

    share: dict[str, float]
    """By name: 1 - variance with the samples / variance without them, at the end of the recording. 0: they say nothing."""
    unseen: tuple[tuple[str, ...], ...]
    """Combinations of which they remove less than a tenth of the variance, by the names that take part."""

    def sentences(self) -> list[str]:
        """A line for each estimate, and one for each combination that is not observable."""
        lines = [f"{name}: the samples remove {100 * share:.3g} % of its variance" for name, share in self.share.items()]
        for names in self.unseen:
            if len(names) == 1:
                lines.append(f"not observable: {names[0]}; give it a smaller start_sigma, or a sensor that it acts on")
            else:
                together = f"{', '.join(names[:-1])} and {names[-1]}"
                lines.append(f"not observable: {together} together, only a combination of them; fix one, or add a sensor")
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
    return compared(plan.estimated, without.covariance[-1], with_samples.covariance[-1])


def compared(names: tuple[str, ...], prior: Array, left: Array) -> Observability:
    """Of the covariances without samples and with them."""
    scale = np.sqrt(np.diag(prior))
    known = scale > 0
    share = {name: float(1 - left[i, i] / prior[i, i]) if known[i] else math.nan for i, name in enumerate(names)}
    among = [name for name, is_known in zip(names, known) if is_known]
    per = np.outer(scale[known], scale[known])
    before, after = prior[np.ix_(known, known)] / per, left[np.ix_(known, known)] / per
    values, vectors = np.linalg.eigh(before)
    independent = values > _SINGULAR * values.max(initial=0.0)
    root = vectors[:, independent] * np.sqrt(values[independent])
    whitener = vectors[:, independent] / np.sqrt(values[independent])
    remains, directions = np.linalg.eigh(whitener.T @ after @ whitener)
    unseen = _sparse(root @ directions[:, remains > UNSEEN])
    return Observability(share, tuple(tuple(name for name, size in zip(among, row) if size > _PART) for row in unseen))


def _sparse(basis: Array) -> list[Array]:
    """Sizes of the components, at most 1, of directions that span the same as the columns, each with as many zeros as elimination gives."""
    rows = basis.T.copy()
    for used in range(len(rows)):
        left = np.abs(rows[used:])
        row, column = divmod(int(np.argmax(left)), left.shape[1])
        rows[[used, used + row]] = rows[[used + row, used]]
        rows[used] /= rows[used, column]
        for other in range(len(rows)):
            if other != used:
                rows[other] -= rows[other, column] * rows[used]
    return [np.abs(row) / np.abs(row).max() for row in rows]
