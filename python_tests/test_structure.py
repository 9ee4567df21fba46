"""Who may know whom. Arrows go down only: fmu -> include; c_api -> the products -> hybrid -> maths -> base.

The plain data of include/hnav, types.h and the options, belong to nobody: every room may include them.
"""

import re
from pathlib import Path

import pytest

from checkout import TOP

BELOW = {"base": (), "maths": ("base",), "hybrid": ("maths", "base")}
PRODUCTS = ("attitude", "ins_error", "calibration", "simulation")
SHARED_BY_FMUS = ("attitude_filter", "aircraft")
FMUS = sorted(p.parent.name for p in TOP.glob("fmu/*/model.cpp"))
# Room of the includer: the rooms that it may include from, its own beside them.
ALLOWED = {
    **{f"c_src/{room}": {room, *below} for room, below in BELOW.items()},
    **{f"c_src/{room}": {room, "hybrid", "maths", "base", "hnav"} for room in PRODUCTS},
    "c_src/options": {"options", "base"},
    "c_src/c_api": {"c_api", *PRODUCTS, "options", "hybrid", "maths", "base", "hnav"},
    "c_src/include": {"hnav"},
    # An FMU knows the library by its public headers alone, the adapter, and what FMUs of its kind share.
    **{f"fmu/{room}": {room, "adapter", "hnav"} for room in ("adapter", *SHARED_BY_FMUS, "bench", "fuzz", "tests")},
    **{f"fmu/{room}": {room, *SHARED_BY_FMUS, "adapter", "hnav"} for room in FMUS},
}
PLAIN_DATA = re.compile(r"hnav/(types|options/\w+)\.h")
ROOMS = {room for rooms in ALLOWED.values() for room in rooms}
# Inside attitude: the filters know what they share, and not each other.
ALLOWED_IN_ATTITUDE = {"common": {"common"}, "ahrs": {"ahrs", "common"}, "hrekf": {"hrekf", "common"}}


def includes(path: Path) -> list[str]:
    return re.findall(r'#\s*include\s+[<"]([^>"]+)[>"]', path.read_text())


def sources(folder: Path) -> list[Path]:
    return [p for p in folder.rglob("*") if p.suffix in (".hpp", ".cpp", ".h", ".c")]


@pytest.mark.parametrize("folder", ALLOWED)
def test_a_room_includes_only_what_it_may_know(folder):
    assert sources(TOP / folder)
    for source in sources(TOP / folder):
        for name in includes(source):
            room = name.split("/")[0]
            if room in ROOMS and "/" in name and not PLAIN_DATA.fullmatch(name):
                assert room in ALLOWED[folder], f"{source.relative_to(TOP)} includes {name}"


def test_every_folder_of_the_fmus_is_a_room():
    assert {p.name for p in (TOP / "fmu").iterdir() if p.is_dir()} == {r.split("/")[1] for r in ALLOWED if r.startswith("fmu/")}


def test_plain_data_depend_on_nothing_but_plain_data():
    for header in [
        p for p in sources(TOP / "c_src/include") if PLAIN_DATA.fullmatch(p.relative_to(TOP / "c_src/include").as_posix())
    ]:
        assert all(PLAIN_DATA.fullmatch(name) for name in includes(header) if name.startswith("hnav/")), header


@pytest.mark.parametrize("room", ALLOWED_IN_ATTITUDE)
def test_the_attitude_filters_share_the_common_room_and_nothing_else(room):
    for source in sources(TOP / "c_src/attitude" / room):
        for name in includes(source):
            if name.startswith("attitude/"):
                assert name.split("/")[1] in ALLOWED_IN_ATTITUDE[room], f"{source.relative_to(TOP)} includes {name}"


def test_sundials_is_behind_one_file():
    users = {
        p.name
        for p in [*sources(TOP / "c_src"), *sources(TOP / "fmu")]
        if any(name.startswith(("sundials/", "arkode/", "cvode/", "nvector/", "sunnonlinsol/")) for name in includes(p))
    }
    assert users == {"sundials_names.hpp"}
    assert "hybrid/sundials_names.hpp" in includes(TOP / "c_src/hybrid/propagator.cpp")
