"""What a binary asks of the machine it runs on, and what it shows of itself: for ELF files, DLLs and Mach-O files alike.

    python release/binaries.py DIST

looks at every FMU of DIST/fmi2 and DIST/fmi3 and at the library in wheel and .tar.gz, and exits with the first thing that
is wrong.
"""

from __future__ import annotations

import io
import sys
import tarfile
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path

import lief
import pefile
from elftools.elf.dynamic import DynamicSection
from elftools.elf.elffile import ELFFile
from elftools.elf.gnuversions import GNUVerNeedSection
from elftools.elf.sections import SymbolTableSection

TOP = Path(__file__).resolve().parents[1]
GLIBC = (2, 17)
MACOS = (11, 0, 0)
# What Windows 10 and macOS bring themselves; of Linux, the C library (threads were a file of their own until 2.34) and its loader.
SYSTEM = (
    "libc.so.6",
    "libm.so.6",
    "libdl.so.2",
    "libpthread.so.0",
    "ld-linux",
    "kernel32.dll",
    "ntdll.dll",
    "ucrtbase.dll",
    "api-ms-win-crt-",
    "/usr/lib/libSystem.B.dylib",
)

# zig's linker shows its own marks, and C++'s new and delete, which macOS makes one with those of the program that loads the file.
OF_EVERY_DYLIB = ("__mh_dylib_header", "___dso_handle", "__Zn", "__Zd")


@dataclass(frozen=True)
class Needs:
    """exports: names that others can call. libraries: what has to be there. glibc: highest version of a symbol, or None; macos: the
    first that takes it, or None. signed: None where no signature is asked for; Macs with Apple silicon load nothing that is not.

    paths: whether the place of this checkout is written in it.
    """

    exports: tuple[str, ...]
    libraries: tuple[str, ...]
    glibc: tuple[int, ...] | None = None
    macos: tuple[int, ...] | None = None
    signed: bool | None = None
    paths: bool = False


def needs(content: bytes) -> Needs:
    """content: of an ELF file, a DLL or a Mach-O file for one processor."""
    if content.startswith(b"\x7fELF"):
        what = _needs_of_elf(content)
    elif content.startswith(b"\xcf\xfa\xed\xfe"):
        what = _needs_of_mach_o(content)
    else:
        what = _needs_of_dll(content)
    return replace(what, paths=str(TOP).encode() in content)


def _needs_of_elf(content: bytes) -> Needs:
    elf = ELFFile(io.BytesIO(content))
    exports, libraries, versions = [], [], []
    for section in elf.iter_sections():
        if isinstance(section, DynamicSection):
            libraries += [tag.needed for tag in section.iter_tags("DT_NEEDED")]
        elif isinstance(section, GNUVerNeedSection):
            names = (version.name for _, wanted in section.iter_versions() for version in wanted)
            versions += [tuple(map(int, n.removeprefix("GLIBC_").split("."))) for n in names if n.startswith("GLIBC_2")]
        elif isinstance(section, SymbolTableSection) and section.name == ".dynsym":
            # Names of versions are absolute symbols, and nothing that anyone calls.
            exports += [s.name for s in section.iter_symbols() if s.name and s["st_shndx"] not in ("SHN_UNDEF", "SHN_ABS")]
    return Needs(tuple(exports), tuple(libraries), max(versions, default=None))


def _needs_of_dll(content: bytes) -> Needs:
    dll = pefile.PE(data=content)
    exports = [s.name.decode() for s in dll.DIRECTORY_ENTRY_EXPORT.symbols]
    return Needs(tuple(exports), tuple(entry.dll.decode().lower() for entry in dll.DIRECTORY_ENTRY_IMPORT))


def _needs_of_mach_o(content: bytes) -> Needs:
    lief.logging.disable()  # it speaks of every list that is empty
    file = lief.MachO.parse(list(content))
    binary = file.at(0)
    # C names have an underscore before them.
    exports = [s.name.removeprefix("_") for s in binary.exported_symbols if not s.name.startswith(OF_EVERY_DYLIB)]
    # The name of the file itself stands among the libraries.
    own = lief.MachO.LoadCommand.TYPE.ID_DYLIB
    libraries = [library.name for library in binary.libraries if library.command != own]
    signed = binary.has_code_signature if binary.header.cpu_type == lief.MachO.Header.CPU_TYPE.ARM64 else None
    return Needs(tuple(exports), tuple(libraries), macos=tuple(binary.build_version.minos), signed=signed)


def faults(what: Needs, prefix: str) -> list[str]:
    """Sentences, one for each rule that a binary breaks whose exports should all begin with prefix."""
    found = [f"exports {name}" for name in what.exports if not name.startswith(prefix)]
    if not what.exports:
        found.append("exports nothing")
    found += [f"needs {library}" for library in what.libraries if not library.startswith(SYSTEM)]
    if what.glibc and what.glibc > GLIBC:
        found.append(f"needs glibc {'.'.join(map(str, what.glibc))}")
    if what.macos and what.macos > MACOS:
        found.append(f"needs macOS {'.'.join(map(str, what.macos))}")
    if what.signed is False:
        found.append("is not signed")
    if what.paths:
        found.append(f"holds the path {TOP}")
    return found


def binaries(dist: Path) -> dict[str, tuple[bytes, str]]:
    """Content and prefix of the exports of every released binary, by a name for people."""
    found = {}
    for version in (2, 3):
        for fmu in sorted((dist / f"fmi{version}").glob("*.fmu")):
            with zipfile.ZipFile(fmu) as archive:
                for name in (n for n in archive.namelist() if n.startswith("binaries/") and not n.endswith("/")):
                    found[f"fmi{version}/{fmu.name} {name}"] = archive.read(name), f"fmi{version}"
    return found | libraries(dist)


def libraries(dist: Path) -> dict[str, tuple[bytes, str]]:
    """The same of the library in wheels and .tar.gz."""
    found = {}
    for wheel in sorted(dist.glob("hnav-*.whl")):
        with zipfile.ZipFile(wheel) as archive:
            for name in (n for n in archive.namelist() if n.startswith("hnav/libhnav.")):
                found[f"{wheel.name} {name}"] = archive.read(name), "hnav_"
    for package in sorted(dist.glob("libhnav-dev*.tar.gz")):
        with tarfile.open(package) as archive:
            for member in (m for m in archive.getmembers() if m.isfile() and "libhnav.so" in m.name):
                found[f"{package.name} {member.name}"] = archive.extractfile(member).read(), "hnav_"
    return found


def main(dist: Path) -> None:
    highest = (0,)
    released = binaries(dist)
    for name, (content, prefix) in released.items():
        what = needs(content)
        wrong = faults(what, prefix)
        if wrong:
            sys.exit(f"binaries: {name} {'; '.join(wrong)}")
        highest = max(highest, what.glibc or (0,))
    if not released:
        sys.exit(f"binaries: nothing in {dist}")
    print(
        f"{len(released)} binaries: nothing beside the system's C library needed, highest glibc symbol "
        f"{'.'.join(map(str, highest))}, macOS {MACOS[0]} and newer"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
