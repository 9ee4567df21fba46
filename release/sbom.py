"""What is inside a release that others wrote, as CycloneDX 1.6 in JSON: name, version, licence, hash and origin of each part.

    python release/sbom.py library BUILD      BUILD/hnav.cdx.json, which cpack puts into the packages of the C library
    python release/sbom.py dist BUILD DIST    DIST/hnav-VERSION.cdx.json: every file of DIST and what it holds; DIST/SHA256SUMS

BUILD/parts.json says where the build took the parts from, and their versions are read there. The hash of a part is that of
the list of its files: cd FOLDER && find . -type f | LC_ALL=C sort | xargs -d '\\n' sha256sum | sha256sum
"""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import sys
import uuid
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import version as installed_version
from pathlib import Path

import source_date
from cyclonedx.model import ExternalReference, ExternalReferenceType, HashAlgorithm, HashType, Property, XsUri
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.license import DisjunctiveLicense, License, LicenseExpression
from cyclonedx.output.json import JsonV1Dot6
from packages import version
from packageurl import PackageURL

LICENCE = "BSD-3-Clause"
ZIG_PARTS = ("libc++", "libc++abi", "libunwind", "compiler_rt")
# What is inside, by name of part: the library of Linux, that of Windows, and FMUs, which hold binaries of both.
LIBRARY = ("SUNDIALS", "Eigen", *ZIG_PARTS, "glibc")
DLL = ("SUNDIALS", "Eigen", *ZIG_PARTS, "mingw-w64")
FMU = {v: ("SUNDIALS", "Eigen", f"FMI {v} headers", *ZIG_PARTS, "glibc", "mingw-w64") for v in (2, 3)}
WHEEL = tuple(dict.fromkeys(LIBRARY + FMU[2] + FMU[3]))


@dataclass(frozen=True)
class Part:
    """Something that others wrote. licence: as SPDX writes it; text: the file that says it, where it has to travel along.

    purl: by which databases of vulnerabilities know it. origin: an address, and what there is to say of it. archive: SHA-256 of what
    was downloaded from there, where that is one file.
    """

    name: str
    version: str
    licence: str
    sha256: str
    purl: str
    origin: str
    remark: str
    archive: str = ""
    text: Path | None = None

    def component(self) -> Component:
        hashes = [HashType(alg=HashAlgorithm.SHA_256, content=self.archive)] if self.archive else []
        return Component(
            name=self.name,
            version=self.version,
            type=ComponentType.LIBRARY,
            bom_ref=self.name,
            licenses=[_licence(self.licence)],
            hashes=[HashType(alg=HashAlgorithm.SHA_256, content=self.sha256)],
            purl=PackageURL.from_string(self.purl),
            external_references=[
                ExternalReference(
                    type=ExternalReferenceType.DISTRIBUTION, url=XsUri(self.origin), comment=self.remark, hashes=hashes
                )
            ],
            properties=[Property(name="hnav:hash", value="SHA-256 of the sorted list that sha256sum makes of the part's files")],
        )


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def tree_sha256(folder: Path, pattern: str = "**/*") -> str:
    """Of the list of the folder's files that fit the pattern. Exits when there is none."""
    files = sorted((f"./{p.relative_to(folder)}", p) for p in folder.glob(pattern) if p.is_file())
    if not files:
        sys.exit(f"sbom: there is no {pattern} in {folder}")
    return sha256("".join(f"{sha256(p.read_bytes())}  {name}\n" for name, p in files).encode())


def defined(header: Path, name: str) -> str:
    """What the header defines as name, without quotes. Exits when it does not."""
    found = re.search(rf'#\s*define {name}\s+"?([^"\s]+)', header.read_text())
    if not found:
        sys.exit(f"sbom: {header} does not define {name}")
    return found[1]


def read_parts(build: Path) -> dict[str, Part]:
    """All that a release can hold, by name, as the build used them."""
    where = json.loads((build / "parts.json").read_text())
    parts = [
        _sundials(Path(where["SUNDIALS"]["folder"]), Path(where["SUNDIALS"]["built"])),
        _eigen(Path(where["Eigen"]["folder"]), where["Eigen"]["version"]),
        *(_fmi_headers(Path(where["FMI"]["folder"]), v) for v in (2, 3)),
        *_of_zig(Path(where["zig"]["program"])),
    ]
    return {part.name: part for part in parts}


def _sundials(source: Path, built: Path) -> Part:
    number = defined(built / "install" / "include" / "sundials" / "sundials_config.h", "SUNDIALS_VERSION")
    origin, archive, remark = f"https://github.com/LLNL/sundials/tree/v{number}", "", "from a folder with the unpacked sources"
    if (built / "origin.txt").is_file():
        origin, archive = (built / "origin.txt").read_text().split()
        remark = "upstream release" if origin.startswith("https:") else "archive of the distribution's source package"
    purl = f"pkg:github/LLNL/sundials@v{number}"
    return Part("SUNDIALS", number, "BSD-3-Clause", tree_sha256(source), purl, origin, remark, archive)


def _eigen(folder: Path, number: str) -> Part:
    origin = f"https://gitlab.com/libeigen/eigen/-/tree/{number}"
    remark = "headers as the machine that builds has them installed (libeigen3-dev)"
    return Part(
        "Eigen", number, "MPL-2.0", tree_sha256(folder, "Eigen/**/*"), f"pkg:gitlab/libeigen/eigen@{number}", origin, remark
    )


def _fmi_headers(folder: Path, fmi: int) -> Part:
    number = defined(folder / f"fmi{fmi}Functions.h", f"fmi{fmi}Version")
    fmpy = installed_version("fmpy")
    return Part(
        f"FMI {fmi} headers", number, "BSD-2-Clause", tree_sha256(folder, f"fmi{fmi}*.h"),
        f"pkg:github/modelica/fmi-standard@v{number}", f"https://pypi.org/project/fmpy/{fmpy}/", f"from fmpy {fmpy}",
    )  # fmt: skip


def _of_zig(program: Path) -> list[Part]:
    """What zig links into every binary: its C++ library and run-time, and the C library's start."""
    library = program.parent / "lib"
    number = subprocess.run([program, "version"], capture_output=True, text=True, check=True).stdout.strip()
    origin, remark = f"https://pypi.org/project/ziglang/{number}/", f"from ziglang {number}"
    packed = int(defined(library / "libcxx" / "include" / "__config", "_LIBCPP_VERSION"))
    llvm = f"{packed // 10000}.{packed // 100 % 100}.{packed % 100}"
    mingw_header = library / "libc" / "include" / "any-windows-any" / "_mingw_mac.h"
    mingw = ".".join(defined(mingw_header, f"__MINGW64_VERSION_{n}") for n in ("MAJOR", "MINOR"))
    glibc = defined_by_toolchain("HNAV_GLIBC")

    def part(name: str, number: str, licence: str, folder: str, purl: str, said: str, text: str = "") -> Part:
        path = library / folder
        return Part(name, number, licence, tree_sha256(path), purl, origin, said, text=path / text if text else None)

    of_llvm, llvm_licence = f"pkg:github/llvm/llvm-project@llvmorg-{llvm}", "Apache-2.0 WITH LLVM-exception"
    return [
        part("libc++", llvm, llvm_licence, "libcxx", f"{of_llvm}#libcxx", remark, "LICENSE.TXT"),
        part("libc++abi", llvm, llvm_licence, "libcxxabi", f"{of_llvm}#libcxxabi", remark),
        part("libunwind", llvm, llvm_licence, "libunwind", f"{of_llvm}#libunwind", remark),
        part("compiler_rt", number, "MIT", "compiler_rt", f"pkg:pypi/ziglang@{number}", remark),
        part("glibc", glibc, "LGPL-2.1-or-later", "libc/glibc", f"pkg:generic/glibc@{glibc}",
             f"{remark}: the start of a shared object; the C library itself is the system's", "LICENSES"),
        part("mingw-w64", mingw, "ZPL-2.1", "libc/mingw", f"pkg:generic/mingw-w64@{mingw}", f"{remark}: in binaries of Windows", "COPYING"),
    ]  # fmt: skip


def defined_by_toolchain(name: str) -> str:
    """A variable that cmake/toolchains/x86_64-linux.cmake sets."""
    toolchain = Path(__file__).parents[1] / "cmake" / "toolchains" / "x86_64-linux.cmake"
    return re.search(rf"set\({name} (\S+)\)", toolchain.read_text())[1]


def _licence(spdx: str) -> License:
    return LicenseExpression(spdx) if " " in spdx else DisjunctiveLicense(id=spdx)


def _file(name: str, content: bytes) -> Component:
    return Component(
        name=name, type=ComponentType.FILE, bom_ref=name, hashes=[HashType(alg=HashAlgorithm.SHA_256, content=sha256(content))]
    )


def document(
    subject: str, parts: Iterable[Part], files: Mapping[str, bytes] = {}, holds: Mapping[str, Iterable[str]] = {}
) -> bytes:
    """The list of what is in subject. files: its binaries or archives, listed by their hash; holds: names of parts in each of them,
    all parts where it says nothing. Equal arguments and date give equal bytes."""
    found = list(parts)
    bom = Bom()
    bom.metadata.timestamp = source_date.date()
    bom.metadata.component = Component(
        name=subject, version=version(), type=ComponentType.LIBRARY, bom_ref=subject,
        licenses=[_licence(LICENCE)], purl=PackageURL.from_string(f"pkg:generic/hnav@{version()}"),
    )  # fmt: skip
    components = {part.name: part.component() for part in found}
    owners = {name: _file(name, content) for name, content in files.items()}
    for component in [*components.values(), *owners.values()]:
        bom.components.add(component)
    bom.register_dependency(bom.metadata.component, [*components.values(), *owners.values()])
    for name, owner in owners.items():
        bom.register_dependency(owner, [components[n] for n in holds.get(name, components)])
    said = "".join(f"{name} {part.version} {part.sha256}" for name, part in sorted({p.name: p for p in found}.items()))
    said += "".join(f"{name} {sha256(content)}" for name, content in sorted(files.items()))
    bom.serial_number = uuid.uuid5(uuid.NAMESPACE_URL, f"{subject} {version()} {source_date.seconds()} {said}")
    return JsonV1Dot6(bom).output_as_string(indent=1).encode() + b"\n"


def holdings(name: str) -> tuple[str, ...]:
    """Names of the parts in a file of DIST, or in a library, by its path."""
    if name.endswith(".dll"):
        return DLL
    if name.startswith("libhnav-dev") or name.endswith(".so"):
        return LIBRARY
    return WHEEL if name.endswith(".whl") else FMU[3 if name.startswith("fmi3/") else 2]


def library(build: Path) -> None:
    parts = read_parts(build)
    (build / "hnav.cdx.json").write_bytes(document("libhnav", [parts[n] for n in LIBRARY]))


def dist(build: Path, folder: Path) -> None:
    """Names every part on standard output."""
    parts = read_parts(build)
    list_of_all = folder / f"hnav-{version()}.cdx.json"
    files = {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    list_of_all.write_bytes(document("hnav", parts.values(), files, {name: holdings(name) for name in files}))
    files[list_of_all.name] = list_of_all.read_bytes()
    sums = "".join(f"{sha256(files[name])}  {name}\n" for name in sorted(files))
    (folder / "SHA256SUMS").write_text(sums)
    print(f"{list_of_all.name}: {', '.join(f'{p.name} {p.version}' for p in parts.values())}")


if __name__ == "__main__":
    {"library": library, "dist": dist}[sys.argv[1]](*map(Path, sys.argv[2:]))
