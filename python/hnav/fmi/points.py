"""How many communication points a run may have."""

from __future__ import annotations

import os

import numpy as np

from hnav.errors import HnavValueError

BYTES_OF_A_POINT = 64  # its time, also as a Python number, and its place in the recording


def check_points(count: float, values: int, step_s: float, latest_s: float) -> None:
    """Raises HnavError for more points, each with so many values, than fit into the memory of this machine, and for steps
    that are nothing beside the time. latest_s: the largest time, without its sign."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    needed = count * (8 * values + BYTES_OF_A_POINT)
    if not needed < memory:
        need = f"{count:.3g} points need {needed / 1e9:.3g} GB of memory, this machine has {memory / 1e9:.3g}"
        raise HnavValueError("option", f"step_s = {step_s:g}: {need}; take a coarser step or an earlier stop", "step_s")
    if step_s < 4 * np.spacing(latest_s):
        raise HnavValueError("option", f"step_s = {step_s:g}: is lost in rounding beside times of {latest_s:g} s", "step_s")
