"""The library exports the functions that the headers declare, and at most 160 of them."""

import re
import subprocess
import sys

import pytest

from checkout import TOP
from hnav.native.library import library_path

MOST = 160


def declared() -> set[str]:
    """Functions of the public headers."""
    found: set[str] = set()
    for header in (TOP / "c_src" / "include" / "hnav").glob("*.h"):
        text = re.sub(r"/\*.*?\*/", "", header.read_text(), flags=re.DOTALL)
        found |= set(re.findall(r"HNAV_API[^;(]*?\b(hnav_\w+)\(", text))
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="nm lists the symbols of an ELF file")
def test_the_library_exports_the_functions_of_the_headers_and_nothing_else():
    lines = subprocess.check_output(["nm", "-D", "--defined-only", library_path()], text=True).splitlines()
    assert {line.split()[-1] for line in lines} == declared()


def test_the_functions_are_few():
    assert len(declared()) <= MOST
