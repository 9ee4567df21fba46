"""What the tests of FMUs and systems share: the standard's schemas, and an importer that is not installed everywhere."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu


def assert_fits_the_standard(path: Path, version: int) -> None:
    """fmpy's own checks, and the schemas that come with it."""
    assert validate_fmu(str(path)) == []
    lxml = pytest.importorskip("lxml.etree")
    schemas = Path(fmpy.__file__).parent / "schema" / f"fmi{version}"
    with zipfile.ZipFile(path) as archive:
        # FMI 2 archives have the terminals of FMI 3.
        documents = {
            "modelDescription.xml": schemas / f"fmi{version}ModelDescription.xsd",
            "terminalsAndIcons/terminalsAndIcons.xml": schemas.parent / "fmi3" / "fmi3TerminalsAndIcons.xsd",
        }
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
