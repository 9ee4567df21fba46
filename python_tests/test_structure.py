"""Which folder may include which. Dependencies point down only: fmu -> include; c_api -> the products -> estimation -> signals -> hybrid -> maths
-> base; in Python
studies -> twins, makers -> cli -> reports, certify -> systems -> fmi, simulation -> filters -> io -> native.

The plain data of include/hnav, types.h and the options, belong to no room: every room may include them.
"""

import ast
import re
from pathlib import Path

import pytest

import hnav
from checkout import TOP

BELOW = {
    "base": (),
    "maths": ("base",),
    "hybrid": ("maths", "base"),
    "signals": ("hybrid", "maths", "base"),
    "estimation": ("signals", "hybrid", "maths", "base"),
}
PRODUCTS = ("attitude", "ins", "ins_error", "observer", "calibration", "simulation")
SHARED_BY_FMUS = ("attitude_filter", "aircraft", "aid_sensor")
FMUS = sorted(p.parent.name for p in TOP.glob("fmu/*/model.cpp"))
# Room of the includer: the rooms that it may include from, its own beside them.
ALLOWED = {
    **{f"c_src/{room}": {room, *below} for room, below in BELOW.items()},
    **{f"c_src/{room}": {room, *BELOW, "hnav"} for room in PRODUCTS},
    "c_src/options": {"options", "base"},
    "c_src/c_api": {"c_api", *PRODUCTS, "options", *BELOW, "hnav"},
    "c_src/include": {"hnav"},
    # An FMU includes the public headers of the library, the adapter, and what FMUs of its kind share.
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


def test_the_navigation_filter_does_not_know_its_smoother():
    smoother, tests = TOP / "c_src/ins/smoother", TOP / "c_src/tests"
    inside, outside = sources(smoother), [p for p in sources(TOP / "c_src") if not {smoother, tests} & set(p.parents)]
    known = {name for path in outside for name in includes(path) if name.startswith("ins/smoother/")}
    assert inside and known == {"ins/smoother/smoother.hpp"}
    assert not [p for p in (TOP / "c_src/ins").glob("*.?pp") if any("smoother" in name for name in includes(p))]


def test_sundials_is_behind_one_file():
    users = {
        p.name
        for p in [*sources(TOP / "c_src"), *sources(TOP / "fmu")]
        if any(name.startswith(("sundials/", "arkode/", "cvode/", "nvector/", "sunnonlinsol/")) for name in includes(p))
    }
    assert users == {"sundials_names.hpp"}
    assert "hybrid/sundials_names.hpp" in includes(TOP / "c_src/hybrid/propagator.cpp")


# --------------------------------------------------------------------------------------------- Python

OUTSIDE = ("studies", "twins", "makers")  # the wheel
# Rooms of one floor do not know each other.
FLOORS = (
    ("studies",),
    ("twins", "makers"),
    ("cli",),
    ("reports", "certify"),
    ("systems",),
    ("fmi", "simulation"),
    ("filters",),
    ("io",),
    ("native",),
)
# The modules of hnav itself, which every room may know.
GROUND = {path.stem for path in (TOP / "python/hnav").glob("*.py")} - {"__main__"}
PYTHON_ROOMS = [room for floor in FLOORS for room in floor]


def room_of(module: str) -> str:
    """Of a module by its full name: hnav.io.recordings is in io; hnav and hnav.errors are the ground."""
    parts = module.split(".")
    if parts[0] in OUTSIDE:
        return parts[0]
    return parts[1] if len(parts) > 1 else "__init__"


def imported(path: Path) -> set[str]:
    """Full names of what a module imports of hnav and what is beside it, inside functions too."""
    package = path.relative_to(TOP / "python").parent.parts
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = (
                ".".join([*package[: len(package) - node.level + 1], *filter(None, [node.module])]) if node.level else node.module
            )
            # from hnav import io: the name may be a room.
            names |= {f"{base}.{alias.name}" if base == "hnav" else base for alias in node.names}
    return {name for name in names if name.split(".")[0] in ("hnav", *OUTSIDE)}


def folder_of(room: str) -> Path:
    return TOP / "python" / (room if room in OUTSIDE else f"hnav/{room}")


@pytest.mark.parametrize("room", PYTHON_ROOMS)
def test_a_python_room_imports_only_what_is_below_it(room):
    floor = next(i for i, rooms in enumerate(FLOORS) if room in rooms)
    allowed = {room, *GROUND, "__version__", *(below for rooms in FLOORS[floor + 1 :] for below in rooms)}
    modules = sorted(folder_of(room).rglob("*.py"))
    assert modules
    for path in modules:
        for name in imported(path):
            assert room_of(name) in allowed, f"{path.relative_to(TOP)} imports {name}"


def test_every_python_package_is_a_room_and_says_what_it_holds():
    packages = {path.parent.name: path for path in (TOP / "python/hnav").glob("*/__init__.py")}
    assert packages.keys() == set(PYTHON_ROOMS) - set(OUTSIDE)
    for path in [*packages.values(), *(TOP / f"python/{name}/__init__.py" for name in ("hnav", *OUTSIDE))]:
        assert ast.get_docstring(ast.parse(path.read_text())), f"{path.relative_to(TOP)} says nothing"


def test_the_ground_includes_no_room():
    for name in GROUND - {"__init__"}:
        assert not {room_of(module) for module in imported(TOP / f"python/hnav/{name}.py")} - GROUND


def test_names_of_the_package_are_loaded_from_where_they_stand():
    assert {name: f"hnav.{home}" for name, home in hnav._HOME.items()} == {
        name: getattr(hnav, name).__module__ for name in hnav._HOME
    }
