"""The option lists: what is made of them is fresh, and the library says what they say."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hnav.filters.options import FILTERS, Options
from hnav.native.headers import write_binding
from hnav.native.options import option_rows

TOP = Path(__file__).resolve().parents[1]
FOLDER = TOP / "c_src" / "options"
OTHERS = ("ins", "ins_error", "observer", "magnetometer", "turntable", "imu_mag_sensor", "vehicle", "aid_sensor", "aircraft")
FIRST = 16  # options of a filter that one meets before the advanced ones, at most


def load_generator():
    spec = importlib.util.spec_from_file_location("generate", FOLDER / "generate.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["generate"] = module
    spec.loader.exec_module(module)
    return module


generate = load_generator()


def test_what_is_made_of_the_lists_is_fresh():
    stale = [path.name for path, text in generate.generate().items() if not path.is_file() or path.read_text() != text]
    assert stale == [], "./run generate"


def test_nothing_is_left_of_a_list_that_is_gone():
    made = set(generate.generate())
    assert {*generate.HEADERS.glob("*.h"), *FOLDER.glob("*.cpp"), *FOLDER.glob("*.hpp")} == made
    assert {path.stem for path in FOLDER.glob("*.toml")} == {*generate.LISTS, "shared"} == {*FILTERS, *OTHERS, "shared"}


@pytest.mark.parametrize("name", generate.LISTS)
def test_the_library_says_what_the_list_says(name):
    spec = generate.read_list(name)
    table = option_rows(name)
    assert list(table) == [option.path for option in spec.options]
    for option in spec.options:
        info = table[option.path]
        assert (info.group, info.unit, info.description, info.reason) == (option.group, option.unit, option.text, option.reason)
        assert (info.min, info.max, tuple(info.numbers(info.default))) == (option.min, option.max, option.default)
        assert info.advanced == option.advanced
        items = option.choices.items if option.choices else {}
        assert dict(zip(info.choices, info.choice_descriptions)) == items


@pytest.mark.parametrize("filter", FILTERS)
def test_a_preset_differs_from_the_defaults_where_its_list_says_so(filter):
    spec = generate.read_list(filter)
    assert [preset.name for preset in spec.presets] == list(FILTERS[filter])
    for preset in spec.presets:
        made = Options(filter, preset.name)
        for option in spec.options:
            value = preset.values.get(option.path, option.default)
            got = option_rows(filter)[option.path].numbers(getattr(made, option.path))
            assert tuple(got) == value, option.path


@pytest.mark.parametrize("name", generate.LISTS)
def test_an_option_says_what_it_is_and_why_it_is_so(name):
    options = generate.read_list(name).options
    for option in options:
        assert len(option.text) > 3 and not option.text.endswith("."), option.path
        assert option.reason.endswith(".") and (option.reason[0].isupper() or option.reason[0].isdigit()), option.path
    assert len({option.path for option in options}) == len(options)


@pytest.mark.parametrize("filter", FILTERS)
def test_about_a_dozen_options_of_a_filter_come_first(filter):
    assert 8 <= sum(not option.advanced for option in generate.read_list(filter).options) <= FIRST


LIST = """
name = "thing"
number = 9
text = "A thing."
[groups]
noise = "Noise."
[choices.mode]
prefix = "HNAV_MODE"
text = "Mode."
items.off = "off"
items.on = "on"
[noise.level]
text = "Level"
range = "(0, 1]"
default = 0.5
reason = "Half."
[noise.mode]
text = "Mode"
choices = "mode"
default = "on"
reason = "On."
"""


ROW = """
[noise.extra_rad_s]
text = "One option more"
unit = "rad/s"
range = "[0, 2)"
default = 0.25
reason = "For a test."
"""
DEFAULTS = """
#include "hnav/ahrs.h"
#include "options/lists.hpp"
hnav_ahrs_options hnav_ahrs_defaults(hnav_preset preset) { return hnav::made_from<hnav_ahrs_options>(hnav::ahrs_options, preset); }
"""
AS_PYTHON_SEES_IT = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("hnav.native._hnav", sys.argv[1])
sys.modules[spec.name] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules[spec.name])
from hnav.filters.options import Options, option_table
row = option_table("ahrs")["extra_rad_s"]
print(row.group, row.unit, row.min, row.max, row.default, Options("ahrs", extra_rad_s=0.5))
"""


def test_an_option_is_one_row_of_its_list(tmp_path):
    """A row more in a copy of the list: header, table of the library and Python have it without another change."""
    cxx = shutil.which("c++")
    if cxx is None:
        pytest.skip("no compiler c++")
    copy = tmp_path / "c_src"
    for folder in ("options", "base", "include"):
        shutil.copytree(TOP / "c_src" / folder, copy / folder)
    with (copy / "options" / "ahrs.toml").open("a") as rows:
        rows.write(ROW)
    made = subprocess.run([sys.executable, copy / "options" / "generate.py"], capture_output=True, text=True, check=True).stdout
    assert made.split() == ["c_src/include/hnav/options/ahrs.h", "c_src/options/ahrs.cpp"]
    (copy / "defaults.cpp").write_text(DEFAULTS)
    sources = [*(copy / "options").glob("*.cpp"), copy / "base" / "option_list.cpp", TOP / "c_src" / "c_api" / "options.cpp"]
    flags = ["-std=c++17", "-fPIC", "-shared", f"-I{copy}", f"-I{copy / 'include'}"]
    library, binding = tmp_path / "libhnav.so", tmp_path / "_hnav.py"
    subprocess.run([cxx, *flags, *sources, copy / "defaults.cpp", "-o", library], check=True)
    write_binding(copy / "include", binding, "cc")
    environment = os.environ | {"HNAV_LIBRARY": str(library)}
    seen = subprocess.run([sys.executable, "-c", AS_PYTHON_SEES_IT, binding], env=environment, capture_output=True, text=True)
    assert seen.stdout == "noise rad/s 0.0 2.0 0.25 Options('ahrs', extra_rad_s=0.5)\n", seen.stderr


@pytest.mark.parametrize("old, new, named", [
    ("default = 0.5", "default = 0.0", "noise.level: default 0 is outside"),
    ('range = "(0, 1]"', 'range = "0 to 1"', "noise.level: range = '0 to 1'"),
    ('reason = "Half."', "", "noise.level: 'reason'"),
    ('choices = "mode"', 'choices = "modes"', "noise.mode: 'modes'"),
    ('default = "on"', 'default = "up"', "noise.mode: 'up'"),
    ("[noise.mode]", "[nois.mode]", "nois is no group"),
])  # fmt: skip
def test_an_impossible_list_is_refused_by_name(old, new, named, tmp_path):
    (tmp_path / "shared.toml").write_text("[choices]\n")
    (tmp_path / "thing.toml").write_text(LIST)
    assert [option.default for option in generate.read_list("thing", tmp_path).options] == [(0.5,), (1.0,)]
    (tmp_path / "thing.toml").write_text(LIST.replace(old, new))
    with pytest.raises(generate.ListError, match=f"thing.toml: {named}"):
        generate.read_list("thing", tmp_path)
