"""Who may know whom: python -> fmu -> include -> api -> attitude, calibration, coloured, world -> hybrid, linalg."""

import re
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[1]
# Folder of the includer: what its project includes may begin with.
ALLOWED = {
    "c_src/linalg": {"linalg"},
    "c_src/hybrid": {"hybrid"},
    "c_src/attitude": {"attitude", "hybrid", "linalg"},
    "c_src/calibration": {"calibration", "linalg"},  # and maths/rotation.hpp, see below
    "c_src/coloured": {"coloured", "linalg"},
    "c_src/world": {"world", "linalg"},  # likewise
    "c_src/api": {"api", "attitude", "calibration", "coloured", "hybrid", "linalg", "world", "hnav"},
    "c_src/include": {"hnav"},
    "fmu": {"adapter", "attitude", "hnav"},
}
ALLOWED_FILES = {"c_src/calibration": {"maths/rotation.hpp"}, "c_src/world": {"maths/rotation.hpp"}}
LIBRARY_FOLDERS = {"api", "attitude", "calibration", "coloured", "hybrid", "linalg", "world", "hnav", "adapter"}


def includes(path: Path) -> list[str]:
    return re.findall(r'#\s*include\s+[<"]([^>"]+)[>"]', path.read_text())


@pytest.mark.parametrize("folder", ALLOWED)
def test_a_folder_includes_only_what_it_may_know(folder):
    sources = [p for p in (TOP / folder).rglob("*") if p.suffix in (".hpp", ".cpp", ".h", ".c")]
    assert sources
    for source in sources:
        for name in includes(source):
            first = name.split("/")[0]
            if name in ALLOWED_FILES.get(folder, ()):
                continue
            if first in LIBRARY_FOLDERS and "/" in name:
                assert first in ALLOWED[folder], f"{source.relative_to(TOP)} includes {name}"


def test_sundials_is_behind_one_file():
    users = {
        p.name
        for p in [*(TOP / "c_src").rglob("*.[hc]pp"), *(TOP / "fmu").rglob("*.[hc]pp")]
        if any(name.startswith(("sundials/", "arkode/", "cvode/", "nvector/", "sunnonlinsol/")) for name in includes(p))
    }
    assert users == {"sundials_names.hpp"}
    assert "hybrid/sundials_names.hpp" in includes(TOP / "c_src/hybrid/propagator.cpp")
