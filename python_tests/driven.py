"""Simulated drives: as recordings, sample by sample, and the navigation filter's run over one whose sensors have no errors."""

import numpy as np

from hnav import earth
from hnav.filters.ins import Ins
from hnav.filters.ins_aids import Aids
from hnav.filters.ins_answers import InsRun
from hnav.io.aids import AidSamples
from hnav.io.recordings import Recording
from hnav.native.arrays import Array
from hnav.native.library import SENSORS
from hnav.simulation.vehicle import Drive
from studies.ins.vehicles import Samples


def brought_about(drive: Drive) -> InsRun:
    """The run of a filter that starts from the true state and has rate and force only."""
    latitude, longitude, height = drive.place[0]
    ins = Ins(
        "navigation", solver="closed_form", start="state", start_place="given", start_latitude_rad=latitude,
        start_longitude_rad=longitude, start_height_m=height, start_q_nb=drive.q_nb[0], start_velocity_n_m_s=drive.velocity_n_m_s[0],
        rest_duration_s=1000,
    )  # fmt: skip
    return ins.run(drive.t_s, drive.rate_b_rad_s, drive.force_b_m_s2, Aids())


def missed_m(run: InsRun, drive: Drive) -> float:
    """How far the last row is from the end of the drive."""
    return float(np.linalg.norm(earth.position_of(run.place[-1]) - earth.position_of(drive.place[-1])))


def as_recording(samples: Samples) -> Recording:
    """With its velocities and positions by kind."""
    valid, _, sensor, value = samples.aids.arrays()
    kinds = {kind: sensor == SENSORS.index(kind) for kind in ("velocity", "position")}
    aids = {kind: AidSamples(valid[rows], value[rows, :3], value[rows, 3:]) for kind, rows in kinds.items()}
    return Recording("drive", samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, aids=aids)


def push_aid(ins: Ins, t_s: float, sensor: int, value: Array) -> None:
    """Pushes one row of Aids.arrays."""
    kind = SENSORS[sensor]
    if kind == "mag":
        ins.push_mag(t_s, value[:3])
    elif kind == "velocity":
        ins.push_velocity(t_s, value[:3], value[3:])
    else:
        ins.push_position(t_s, *value[:3], value[3:])
