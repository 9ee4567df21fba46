"""The samples that an attitude filter starts from, in NumPy: those that agree with each other."""

from __future__ import annotations

import math

import numpy as np

from hnav.certify.durations import is_within
from hnav.native.arrays import Array
from twins.ins import turned

G_M_S2 = 9.80665
PATIENCE_S = 1.0


def triad(force_b: Array, field_b: Array) -> Array | None:
    """3 x 3, body to navigation: down against the force, the field across it to the north. None where the two are parallel."""
    down = -force_b / np.linalg.norm(force_b)
    east = np.cross(down, field_b / np.linalg.norm(field_b))
    if not np.linalg.norm(east) > 1e-3:
        return None
    east = east / np.linalg.norm(east)
    return np.stack([np.cross(east, down), east, down])


class AgreeingSamples:
    """The mean of the newest samples of force and field that agree, in the present body axes.

    Each force is within a quarter of gravity, and each sample within a quarter of the mean of those before it, which the gyroscope turns on;
    a sample further away restarts the mean. After PATIENCE_S, or if one sample suffices, any samples do.
    """

    def __init__(self, samples: int):
        self.samples = samples
        self.first_s = self.last_s = math.nan
        self.mean, self.count = [np.zeros(3), np.zeros(3)], [0, 0]

    def add(self, t_s: float, rate: Array, force: Array | None, field: Array | None) -> None:
        """The samples of an instant. rate: of the body since the last instant, rad/s, body axes."""
        if math.isnan(self.first_s):
            self.first_s = t_s
        elif t_s > self.last_s and np.any(rate):
            back = turned(-rate * (t_s - self.last_s))[0]
            self.mean = [back @ mean for mean in self.mean]
        self.last_s = t_s
        patient = self.samples > 1 and is_within(t_s - self.first_s, PATIENCE_S)
        for k, sample in enumerate((force, field)):
            if sample is not None and (patient or self.count[k] < self.samples):
                self.take(k, sample, patient)

    def take(self, k: int, sample: Array, patient: bool) -> None:
        if patient and k == 0 and not abs(np.linalg.norm(sample) - G_M_S2) <= 0.25 * G_M_S2:
            return
        if patient and not np.linalg.norm(sample - self.mean[k]) <= 0.25 * np.linalg.norm(self.mean[k]):
            self.count[k] = 0
        self.count[k] += 1
        self.mean[k] = self.mean[k] + (sample - self.mean[k]) / self.count[k]

    def means(self) -> tuple[Array | None, Array | None]:
        """The means of force and field; None if the samples are too few."""
        force, field = (mean if count >= self.samples else None for mean, count in zip(self.mean, self.count))
        return force, field

    def forget(self) -> None:
        """Forgets the samples, not the time of the first."""
        self.mean, self.count = [np.zeros(3), np.zeros(3)], [0, 0]
