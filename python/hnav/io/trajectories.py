"""Attitudes and places over time out of files: what hnav filter writes, truths, TUM, EuRoC, KITTI, recordings with a reference.

trajectory = read_trajectory("groundtruth.txt")
trajectory.at(t_s).q_nb
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hnav.errors import HnavValueError
from hnav.io.readers import read
from hnav.io.readers.aid_columns import PER, ROLES, aid_column
from hnav.io.readers.cells import is_number
from hnav.io.recordings import RecordingError
from hnav.io.sample_table import read_sample_table
from hnav.rotations import continuous_quaternion, quaternion_of_euler

ANGLES = {"roll": "roll", "pitch": "pitch", "heading": "heading", "yaw": "heading"}
QUATERNION = re.compile(
    r"(?:q|quat|quaternion|orientation|q_rs|attitude)[_. \[]?(?:([wxyz])|([0-3]))\]?(?: ?\[\])?", re.IGNORECASE
)
POSITION = re.compile(r"(?:t|p|pos|position|p_rs_r|translation)?[_. ]?([xyz])(?:[_ ]?[\[(]?m[\])]?)?", re.IGNORECASE)
SIGMAS = {
    "attitude": (("sigma_x_deg", "sigma_y_deg", "sigma_z_deg"), ("sigma_about_north", "sigma_about_east", "sigma_heading")),
    "position": (("sigma_north", "sigma_east", "sigma_down"),),
    "velocity": (("sigma_vn", "sigma_ve", "sigma_vd"),),
}
"""Columns of standard deviations as hnav filter writes them; those of the attitude in deg."""
TUM, KITTI = 8, 12
"""Numbers in a line: t x y z qx qy qz qw, and the rows of a 3 x 4 matrix."""
LONGEST_STEP_S = 1.5
"""Longest interval in s over which rows are interpolated."""


@dataclass(frozen=True)
class Trajectory:
    """Rows of n; NaN where a file has none."""

    name: str
    """Of the file."""
    t_s: np.ndarray
    """n, not decreasing."""
    q_nb: np.ndarray
    """n x 4: body to navigation axes, scalar first."""
    place: np.ndarray
    """n x 3: latitude, longitude in rad, height in m."""
    position_m: np.ndarray
    """n x 3: in axes of the file, where it has no latitudes."""
    velocity_n_m_s: np.ndarray
    """n x 3: north, east, down."""
    sigma: Mapping[str, np.ndarray] = field(default_factory=dict)
    """n x 3 of attitude (rad), position (m) and velocity (m/s), as far as the file has them: about and along navigation axes."""
    angles: str = "none"
    """deg or rad: what roll, pitch and heading were taken for; quaternion, or none."""
    frame: str = ""
    """ned or enu, as far as the file says it."""

    def rows(self, kept: np.ndarray) -> Trajectory:
        """Some of the rows."""
        arrays = {name: value[kept] for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        return replace(self, **arrays, sigma={name: values[kept] for name, values in self.sigma.items()})

    def at(self, t_s: np.ndarray) -> Trajectory:
        """The trajectory interpolated to other times."""
        before = np.clip(np.searchsorted(self.t_s, t_s, side="right") - 1, 0, len(self.t_s) - 1)
        after = np.clip(np.searchsorted(self.t_s, t_s), 0, len(self.t_s) - 1)
        unknown = (self.t_s[after] - self.t_s[before] > LONGEST_STEP_S) | (t_s < self.t_s[0]) | (t_s > self.t_s[-1])

        def between(values: np.ndarray) -> np.ndarray:
            rows = np.isfinite(values).all(axis=1)
            if not rows.any():
                return np.full((len(t_s), values.shape[1]), np.nan)
            made = np.stack([np.interp(t_s, self.t_s[rows], column) for column in values[rows].T], axis=1)
            return np.asarray(np.where(unknown[:, None], np.nan, made))

        # Across the date line a longitude goes on.
        place, known = self.place.copy(), np.isfinite(self.place).all(axis=1)
        place[known, 1] = np.unwrap(place[known, 1])
        q = between(continuous_quaternion(self.q_nb))
        return Trajectory(
            self.name, t_s, q / np.linalg.norm(q, axis=1, keepdims=True), between(place), between(self.position_m),
            between(self.velocity_n_m_s), {name: between(values) for name, values in self.sigma.items()}, self.angles, self.frame,
        )  # fmt: skip


def read_trajectory(path: str | Path) -> Trajectory:
    """A file of any of the formats above. Angles are in deg or rad by their names (roll_deg), else in rad if no heading is beyond a turn
    of them. Raises HnavError that says what is missing."""
    path = Path(path)
    if numbers := _without_header(path):
        return _of_numbers(path, numbers)
    try:
        found = _of_columns(path, *read_sample_table(path, ()))
    except HnavValueError:
        if not _is_recording(path):
            raise
        found = None
    if found is None or not any(np.isfinite(rows).all(axis=1).any() for rows in (found.q_nb, found.place, found.position_m)):
        try:
            return _of_recording(path)
        except RecordingError as error:
            looked_for = (
                "no attitude (q0 to q3; qw, qx, qy, qz; roll, pitch, yaw) and no place (x, y, z; lat_deg, lon_deg, alt_m)"
            )
            because = str(error).removeprefix(f"{path}: ")
            raise HnavValueError("file", f"{path}: {looked_for} over time: {because}") from None
    return found


def read_truth(path: str | Path) -> Trajectory:
    """A trajectory with positions. Raises HnavValueError that names the missing columns."""
    path = Path(path)
    t_s, columns = read_sample_table(path)
    by_role = _aids(columns)
    if missing := [role for role in ("lat_deg", "lon_deg", "alt_m") if role not in by_role]:
        columns_of_truth = "t_s, lat_deg, lon_deg, alt_m, vn, ve, vd, roll, pitch, heading"
        raise HnavValueError("file", f"{path.name} has no column {missing[0]}; a truth has {columns_of_truth}")
    return _of_columns(path, t_s, columns)


def _is_recording(path: Path) -> bool:
    """Whether it is no text."""
    return path.is_dir() or b"\0" in path.open("rb").read(4096)


def _without_header(path: Path) -> list[str]:
    """The lines of a file of TUM or KITTI; none of another."""
    if _is_recording(path):
        return []
    lines = [line for line in path.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip() and line[0] != "#"]
    cells = lines[0].split() if lines else []
    return lines if len(cells) in (TUM, KITTI) and all(map(is_number, cells)) else []


def _of_numbers(path: Path, lines: list[str]) -> Trajectory:
    """Of KITTI the times are the numbers of the rows."""
    try:
        table = np.array([line.split() for line in lines], float)
    except ValueError:
        raise HnavValueError("file", f"{path}: a line is no row of {len(lines[0].split())} numbers") from None
    if table.shape[1] == TUM:
        order = np.argsort(table[:, 0], kind="stable")
        return _made(path, table[order, 0], q_nb=table[order][:, [7, 4, 5, 6]], position_m=table[order, 1:4], angles="quaternion")
    from scipy.spatial.transform import Rotation  # takes longer to load than a table

    poses = table.reshape(-1, 3, 4)
    q = Rotation.from_matrix(poses[:, :, :3]).as_quat()[:, [3, 0, 1, 2]]
    return _made(path, np.arange(len(poses), dtype=float), q_nb=q, position_m=poses[:, :, 3], angles="quaternion")


def _made(path: Path, t_s: np.ndarray, **known: object) -> Trajectory:
    arrays = {name: np.full((len(t_s), width), np.nan) for name, width in
              (("q_nb", 4), ("place", 3), ("position_m", 3), ("velocity_n_m_s", 3))}  # fmt: skip
    return Trajectory(path.stem, t_s, **{**arrays, **known})  # type: ignore[arg-type]


def _of_recording(path: Path) -> Trajectory:
    recording = read(path)
    if recording.reference_q_nb is None:
        raise RecordingError(f"{path}: it is a recording without a reference attitude; hnav filter makes a table of it")
    return _made(path, recording.t_s, q_nb=recording.reference_q_nb, angles="quaternion", frame="enu")


def _aids(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Of latitudes, heights and velocities by their roles, in the first unit of each."""
    found: dict[str, np.ndarray] = {}
    for name, values in columns.items():
        aid = aid_column(name)
        if aid is not None and aid.role not in found:
            found[aid.role] = aid.sign * values * (PER[ROLES[aid.role]][aid.unit] if aid.unit else 1.0)
    return found


def _of_columns(path: Path, t_s: np.ndarray, columns: Mapping[str, np.ndarray]) -> Trajectory:
    aids, nothing = _aids(columns), np.full(len(t_s), np.nan)

    def three(*roles: str) -> np.ndarray:
        return np.stack([aids.get(role, nothing) for role in roles], axis=1)

    position = _by_axis(columns, POSITION, "xyz")
    q_nb, angles = _attitude(columns, len(t_s))
    sigma = {}
    for quantity, choices in SIGMAS.items():
        for names in choices:
            if set(names) <= columns.keys():
                values = np.stack([columns[name] for name in names], axis=1)
                sigma[quantity] = np.radians(values) if quantity == "attitude" else values
    with path.open(encoding="utf-8", errors="replace") as file:
        head = "".join(line for line in file.readlines(20_000) if line.startswith("#"))
    frame = "enu" if "(enu)" in head else "ned" if "(ned)" in head or "north-east-down" in head else ""
    return _made(
        path, t_s, q_nb=q_nb, place=three("lat_deg", "lon_deg", "alt_m") * [np.radians(1), np.radians(1), 1], velocity_n_m_s=three("vn", "ve", "vd"),
        sigma=sigma, angles=angles, frame=frame, **({} if position is None else {"position_m": position}),
    )  # fmt: skip


def _by_axis(columns: Mapping[str, np.ndarray], pattern: re.Pattern[str], axes: str) -> np.ndarray | None:
    """The columns that a pattern finds, in the order of axes; None where one is missing."""
    found: dict[str, np.ndarray] = {}
    for name, values in columns.items():
        if match := pattern.fullmatch(name.strip()):
            axis = next(group for group in match.groups() if group)
            found.setdefault("wxyz"[int(axis)] if axis.isdigit() else axis.lower(), values)
    return np.stack([found[axis] for axis in axes], axis=1) if found.keys() >= set(axes) else None


def _attitude(columns: Mapping[str, np.ndarray], n: int) -> tuple[np.ndarray, str]:
    if (q := _by_axis(columns, QUATERNION, "wxyz")) is not None:
        return q, "quaternion"
    found, unit = {}, ""
    for name, values in columns.items():
        if match := re.fullmatch(r"(roll|pitch|heading|yaw)(?:[_ \[(]*(deg|rad)[\])]?)?", name.strip(), re.IGNORECASE):
            found[ANGLES[match.group(1).lower()]], unit = values, unit or (match.group(2) or "").lower()
    if len(found) < 3:
        return np.full((n, 4), np.nan), "none"
    unit = unit or ("rad" if np.nanmax(np.abs(found["heading"]), initial=0.0) <= 2 * np.pi + 0.01 else "deg")
    euler = np.stack([found[name] for name in ("roll", "pitch", "heading")], axis=1)
    return quaternion_of_euler(np.radians(euler) if unit == "deg" else euler), unit
