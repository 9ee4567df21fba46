"""Raw sequences of KITTI: oxts/timestamps.txt with an instant in each line, oxts/data with a file of one row for each instant.

Geiger et al., Vision meets Robotics: The KITTI Dataset, IJRR 2013; the fields are those of dataformat.txt. Body axes are forward, left, up;
place and velocity are those of the inertial system (RT3003) that measured.
"""

from __future__ import annotations

from pathlib import Path

from hnav.io.readers.streams import Raw, Wishes
from hnav.io.readers.tables import parse, raw_of
from hnav.io.recordings import RecordingError

UNITS = {"gyro": "rad/s", "accel": "m/s2"}
FIELDS = (
    "lat_deg,lon_deg,alt_m,roll,pitch,yaw,vn,ve,v_forward,v_left,vu,ax,ay,az,a_forward,a_left,a_up,gx,gy,gz,w_forward,w_left,w_up,"
    "sigma_h,sigma_vel,navstat,numsats,posmode,velmode,orimode"
)


def is_kitti(path: Path, head: bytes) -> bool:
    """A sequence, or its folder oxts."""
    return _oxts_of(path) is not None


def read_kitti(path: Path, wishes: Wishes) -> Raw:
    """Raises RecordingError."""
    if (folder := _oxts_of(path)) is None:
        raise RecordingError(f"{path}: no sequence of KITTI: give the folder that holds oxts/timestamps.txt and oxts/data")
    times = (folder / "timestamps.txt").read_text().split("\n")
    rows = {int(file.stem): file.read_text().split() for file in (folder / "data").glob("*.txt") if file.stem.isdigit()}
    lines = [f"time,{FIELDS}", *(",".join([times[k], *row]) for k, row in sorted(rows.items()) if k < len(times) and times[k])]
    return raw_of(str(folder), parse(str(folder), "\n".join(lines).encode(), wishes), wishes, UNITS, "kitti")


def _oxts_of(path: Path) -> Path | None:
    found = (folder for folder in (path / "oxts", path) if (folder / "timestamps.txt").is_file() and (folder / "data").is_dir())
    return next(found, None)
