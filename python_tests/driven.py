"""What the navigation filter makes of a simulated drive whose sensors have no errors."""

import numpy as np

from hnav.filters.ins import Ins
from hnav.filters.ins_aids import Aids
from hnav.filters.ins_answers import InsRun
from hnav.reference import earth
from hnav.simulation.vehicle import Drive


def brought_about(drive: Drive) -> InsRun:
    """The run of a filter that knows the beginning and has rate and force alone."""
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
