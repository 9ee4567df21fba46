"""Shared by the tests of FMUs and systems: the standard's schemas, and an importer that is not installed everywhere."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from hnav.errors import HnavError
from hnav.fmi.fmus import Fmu, fmu_path


def built_fmu(name: str, version: int = 2) -> Path:
    """Where it is; the test is skipped where it is not built."""
    try:
        return fmu_path(name, version)
    except HnavError as error:
        pytest.skip(str(error))


def assert_fits_the_standard(path: Path, version: int) -> None:
    """fmpy's own checks, and the schemas that come with it."""
    assert validate_fmu(str(path)) == []
    lxml = pytest.importorskip("lxml.etree")
    schemas = Path(fmpy.__file__).parent / "schema" / f"fmi{version}"
    with zipfile.ZipFile(path) as archive:
        documents = {"modelDescription.xml": schemas / f"fmi{version}ModelDescription.xsd"}
        if version == 3:  # which FMI 2 does not have
            documents["terminalsAndIcons/terminalsAndIcons.xml"] = schemas / "fmi3TerminalsAndIcons.xsd"
        for document, schema in documents.items():
            checker = lxml.XMLSchema(lxml.parse(str(schema)))
            assert checker.validate(lxml.fromstring(archive.read(document))), checker.error_log


def ecos():
    """The module ecospy; the test is skipped where it, its library or the command unzip is missing."""
    try:
        ecospy = pytest.importorskip("ecospy", reason="ecospy is not installed", exc_type=ImportError)
    except OSError as error:  # its library needs libtbb12
        pytest.skip(f"ecospy cannot be loaded: {error}")
    if not shutil.which("unzip"):
        pytest.skip("ecospy needs the command unzip")
    return ecospy


def step_once(fmu: Fmu, solver, k: int) -> None:
    """From 10 k ms to 10 (k + 1) ms with the inputs as they are; solver: fmpy's, for Model Exchange."""
    t, end = 0.01 * k, 0.01 * (k + 1)
    if solver is None:
        fmu.do_step(t, 0.01)
        return
    fmu.update_discrete_states()
    fmu.call(fmu.fmu.enterContinuousTimeMode)
    solver.reset(t)
    solver.step(t, end)
    fmu.call(fmu.fmu.setTime, end)
    fmu.call(fmu.fmu.enterEventMode)
