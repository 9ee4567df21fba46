"""Locations of the FMUs that hnav builds."""

from __future__ import annotations

import os
from pathlib import Path

from hnav.errors import HnavValueError
from hnav.places import CHECKOUT, PACKAGE


def fmu_path(name: str, fmi_version: int) -> Path:
    """HNAV_FMUS/fmiN/NAME.fmu, else the one in this package (wheel), else the build of the checkout."""
    folders = [Path(os.environ["HNAV_FMUS"])] if "HNAV_FMUS" in os.environ else [PACKAGE / "fmus", CHECKOUT / "build" / "fmus"]
    for folder in folders:
        path = folder / f"fmi{fmi_version}" / f"{name}.fmu"
        if path.is_file():
            return path
    cure = "./run fmus makes it, or set HNAV_FMUS to its folder"
    raise HnavValueError("option", f"{name}.fmu for FMI {fmi_version} is not built: {cure}")
