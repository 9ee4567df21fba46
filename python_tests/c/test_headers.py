"""The public headers: each compiles alone, as C and as C++."""

import re
import shutil
import subprocess

import pytest

from checkout import TOP

INCLUDE = TOP / "c_src" / "include"
HEADERS = sorted(path.relative_to(INCLUDE).as_posix() for path in INCLUDE.rglob("*.h"))
LANGUAGES = {"c": ("cc", "-std=c99"), "c++": ("c++", "-std=c++11")}


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("header", HEADERS)
def test_a_header_compiles_alone_without_a_warning(header, language):
    compiler, standard = LANGUAGES[language]
    if shutil.which(compiler) is None:
        pytest.skip(f"no compiler {compiler}")
    flags = [standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", f"-I{INCLUDE}"]
    source = f"#include <{header}>\n#include <{header}>\nint after_the_header;\n"
    made = subprocess.run([compiler, *flags, "-x", language, "-"], input=source, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr


def reached(header: str) -> set[str]:
    """The header and all headers that it includes, at any depth."""
    text = (INCLUDE / header).read_text()
    return {header}.union(*(reached(name) for name in re.findall(r'#include "(.*)"', text)))


def test_the_umbrella_includes_every_header():
    assert reached("hnav/hnav.h") == set(HEADERS)
