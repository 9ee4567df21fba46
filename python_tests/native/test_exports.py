"""The library exports the functions that the headers declare, and at most 160 of them."""

import re

from checkout import TOP

MOST = 160


def declared() -> set[str]:
    """Functions of the public headers."""
    found: set[str] = set()
    for header in (TOP / "c_src" / "include" / "hnav").glob("*.h"):
        text = re.sub(r"/\*.*?\*/", "", header.read_text(), flags=re.DOTALL)
        found |= set(re.findall(r"HNAV_API[^;(]*?\b(hnav_\w+)\(", text))
    return found


def test_the_export_map_lists_the_functions_of_the_headers():
    exported = re.findall(r"^  (hnav_\w+);$", (TOP / "c_src" / "c_api" / "hnav.map").read_text(), flags=re.MULTILINE)
    assert exported == sorted(declared())


def test_the_functions_are_few():
    assert len(declared()) <= MOST
