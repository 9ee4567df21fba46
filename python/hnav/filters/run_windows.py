"""The rows of a run in windows: the motion that the errors of an attitude depend on, in axes whose first points forward at the end."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.native.arrays import Array, BoolArray
from hnav.rotations import rotated, rotation_error_rad

Indices = npt.NDArray[np.intp]
MOST = 600  # windows of a run
LEVEL = 0.1  # horizontal part of a body axis below which its heading is undefined
UPRIGHT = math.cos(math.radians(20.0))  # least cosine to the vertical of an axis that is called vertical
LONGEST_S = 0.1  # longest time that a sample counts for
G_M_S2 = 9.81
UNKNOWN_TILT_RAD, UNKNOWN_HEADING_RAD = 1.0, math.pi / math.sqrt(3)  # sigma before any sample; of a uniform heading
ANGLES = ("roll", "pitch", "heading")  # the first errors


@dataclass(frozen=True)
class RowWindows:
    """m windows of the rows with an attitude. Axes: forward, right, down, where forward is body x at the end, horizontally."""

    t_s: Array
    """m: ends, from the first row of the run on."""
    length_s: Array
    """m."""
    rows: Indices
    """Rows of the run with an attitude."""
    begins: Indices
    """m + 1: places in rows, the last behind the last one."""
    matrix: Array
    """rows x 3 x 3: body axes to the axes above."""
    turn: Array
    """m x 3 x 3: integral of that matrix over each window."""
    turn_path: Array
    """m x 3 x 3: the integral of the integral."""
    turned_rad: Array
    """m: angle that the body turns by in each window."""
    heading_rad: float
    """Azimuth of forward in the navigation axes of the run."""
    all_t_s: Array
    """n: instants of the run."""

    @classmethod
    def of(cls, t_s: Array, q_nb: Array) -> RowWindows:
        """Raises HnavValueError when fewer than two rows have an attitude."""
        rows = np.flatnonzero(np.isfinite(q_nb).all(axis=1))
        if len(rows) < 2 or not t_s[rows[-1]] > t_s[rows[0]]:
            raise HnavValueError("size", "the run has no attitude over time: nothing can be observed")
        q = q_nb[rows]
        matrix = np.stack([rotated(q, axis) for axis in np.eye(3)], axis=-1)
        heading = _heading_of(matrix[-1])
        cosine, sine = math.cos(heading), math.sin(heading)
        matrix = np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1.0]]) @ matrix
        t = t_s[rows]
        edges = np.linspace(t[0], t[-1], MOST + 1)[1:]
        ends = np.unique(np.append(np.searchsorted(t, edges, side="right"), len(t)))
        begins = np.r_[1, ends[ends > 1]]
        steps = np.linalg.norm(rotation_error_rad(q[:-1], q[1:]), axis=1)
        turned = np.add.reduceat(np.append(0.0, steps), begins[:-1])
        length = np.diff(t[begins - 1])
        kept = cls(t[begins[1:] - 1] - t_s[0], length, rows, begins, matrix, np.empty(0), np.empty(0), turned, heading, t_s)
        return kept._integrated(matrix)

    @property
    def begin_s(self) -> float:
        """Of the first window, from the first row of the run on."""
        return float(self.all_t_s[self.rows[0]] - self.all_t_s[0])

    def summed(self, values: Array) -> Array:
        """m x ...: sums over the rows of each window."""
        sums: Array = np.add.reduceat(values, self.begins[:-1])
        return sums

    def gyro_biases(self) -> list[str]:
        """Names of the biases of the gyroscope: the axis that stands upright at the start is named so."""
        upright = np.abs(self.matrix[0, 2]) > UPRIGHT
        return [f"gyro bias {axis}" + " (vertical at the start)" * bool(up) for axis, up in zip("xyz", upright)]

    @property
    def steps_s(self) -> Array:
        """Time of each row with an attitude since the one before."""
        t = self.all_t_s[self.rows]
        return np.diff(t, prepend=t[0])

    def _integrated(self, matrix: Array) -> RowWindows:
        dt = self.steps_s
        turn = self.summed(matrix * dt[:, None, None])
        so_far = np.cumsum(matrix * dt[:, None, None], axis=0)
        before = so_far[self.begins[:-1] - 1]
        path = self.summed(so_far * dt[:, None, None]) - before * self.length_s[:, None, None]
        return replace(self, matrix=matrix, turn=turn, turn_path=path)

    def held(self) -> RowWindows:
        """The same with the body held as at the start."""
        still = self._integrated(np.broadcast_to(self.matrix[0], self.matrix.shape))
        return replace(still, turned_rad=np.zeros(len(self.t_s)))

    def seconds(self, used: BoolArray) -> Array:
        """m: time in each window that the samples used in these rows (n) count for."""
        at = np.flatnonzero(used[self.rows])
        stands = np.zeros(len(self.rows))
        t = self.all_t_s[self.rows]
        stands[at] = np.minimum(np.diff(t[at], prepend=t[0] - LONGEST_S), LONGEST_S) if len(at) else 0.0
        sums = self.summed(stands)
        sums[0] += stands[0]
        return sums

    def forward(self, vector: Array) -> Array:
        """A vector of the navigation axes in those of the windows."""
        cosine, sine = math.cos(self.heading_rad), math.sin(self.heading_rad)
        return np.array([cosine * vector[0] + sine * vector[1], cosine * vector[1] - sine * vector[0], vector[2]])


def _heading_of(matrix: Array) -> float:
    """Azimuth of body x, or of body z where x is upright."""
    for axis in (0, 2):
        if math.hypot(*matrix[:2, axis]) > LEVEL:
            return math.atan2(matrix[1, axis], matrix[0, axis])
    return 0.0


def block(weight: Array, form: Array) -> Array:
    """m x n x n: one quadratic form, weighted."""
    return np.asarray(weight[:, None, None] * form)


def cross(vector: Array) -> Array:
    """3 x 3: vector x."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
