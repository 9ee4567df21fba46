"""What pip calls to build hnav from source: scikit-build-core, and what it cannot ask for by itself.

Where the machine has no C++ compiler, zig (of the package ziglang) is one; where it has no Eigen, a package brings the headers.
The rest of the build stands in pyproject.toml and CMakeLists.txt.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import sys
import tomllib
from pathlib import Path

from scikit_build_core import build

build_editable = build.build_editable
build_sdist = build.build_sdist
get_requires_for_build_editable = build.get_requires_for_build_editable
get_requires_for_build_sdist = build.get_requires_for_build_sdist
# Without it pip would build everything a first time to read the name.
prepare_metadata_for_build_wheel = build.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = build.prepare_metadata_for_build_editable

TOP = Path(__file__).resolve().parents[2]
# Of the package's own dependencies: cffi reads the C headers, fmpy has those of FMI.
AT_BUILD = ("cffi", "fmpy")
COMPILERS = ("c++", "g++", "clang++")
EIGEN_FOLDERS = ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3")


def has_compiler() -> bool:
    return bool(os.environ.get("CXX")) or any(map(shutil.which, COMPILERS))


def has_eigen() -> bool:
    given = any(os.environ.get(name) for name in ("Eigen3_DIR", "Eigen3_ROOT", "CMAKE_PREFIX_PATH"))
    return given or any(Path(folder).is_dir() for folder in EIGEN_FOLDERS)


def builds(config_settings: dict | None) -> bool:
    """False when the caller has built everything before, as release/wheel.py."""
    return str((config_settings or {}).get("wheel.cmake", "true")).lower() != "false"


def get_requires_for_build_wheel(config_settings: dict | None = None) -> list[str]:
    """What this machine lacks, beside the packages of pyproject.toml."""
    if not builds(config_settings):
        return []
    dependencies = tomllib.loads((TOP / "pyproject.toml").read_text())["project"]["dependencies"]
    packages = [*build.get_requires_for_build_wheel(config_settings), *(d for d in dependencies if d.startswith(AT_BUILD))]
    packages += [] if has_compiler() else ["ziglang>=0.13"]
    packages += [] if has_eigen() else ["cmeel-eigen>=3.4,<5"]
    return packages


def build_wheel(wheel_directory: str, config_settings: dict | None = None, metadata_directory: str | None = None) -> str:
    settings = dict(config_settings or {})
    if builds(settings) and not has_compiler():
        settings.setdefault("cmake.toolchain-file", str(zig_toolchain()))
    if builds(settings) and not has_eigen():
        packages = Path(importlib.util.find_spec("cmeel").submodule_search_locations[0]).parent
        os.environ["CMAKE_PREFIX_PATH"] = str(packages / "cmeel.prefix")
    return build.build_wheel(wheel_directory, settings, metadata_directory)


def zig_toolchain() -> Path:
    """The toolchain file for this machine. Exits where zig is not set up for it."""
    toolchain = TOP / "cmake" / "toolchains" / f"{platform.machine()}-{platform.system().lower()}.cmake"
    if platform.system() != "Linux" or not toolchain.is_file():
        sys.exit(f"hnav: {platform.system()} on {platform.machine()} needs a C++17 compiler in PATH to build from source")
    os.environ["HNAV_ZIG"] = str(Path(importlib.util.find_spec("ziglang").origin).with_name("zig"))
    return toolchain
