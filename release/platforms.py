"""The machines that a release is for, by the name of their toolchain file in cmake/toolchains."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Platform:
    """Where an FMU of each version keeps its binary, what a wheel is called, and what starts a program of the platform on this machine.

    fmi2: None where FMI 2 has no name for the platform. wheel: pip's name for it; library: what build and wheel call ours. here: its
    programs run on the machine that makes releases. emulators: names to look for; emulator_arguments: words behind the name; a folder
    among them has to be there. debian: packages that bring both, nothing where no emulator is known.
    """

    name: str
    fmi2: str | None
    fmi3: str
    suffix: str
    wheel: str
    library: str
    here: bool = False
    emulators: tuple[str, ...] = ()
    emulator_arguments: tuple[str, ...] = ()
    debian: str = ""

    def folder(self, version: int) -> str | None:
        return self.fmi2 if version == 2 else self.fmi3

    def runner(self) -> list[str] | None:
        """The words before a program, or None when its emulator is not complete here."""
        if self.here:
            return []
        found = next((path for name in self.emulators if (path := shutil.which(name))), None)
        complete = all(Path(word).is_dir() for word in self.emulator_arguments if word.startswith("/"))
        return [found, *self.emulator_arguments] if found and complete else None

    def advice(self) -> str:
        """How to get what runner() lacks."""
        if not self.debian:
            return "its programs run on such a machine only; what it asks for and shows is read from the file"
        folders = [word for word in self.emulator_arguments if word.startswith("/")]
        wanted = " with ".join([" or ".join(self.emulators), *folders])
        return f"{wanted} is missing (Debian, Ubuntu: apt-get install {self.debian})"


PLATFORMS = (
    Platform("x86_64-linux", "linux64", "x86_64-linux", ".so", "manylinux_2_17_x86_64", "libhnav.so", here=True),
    # Debian's wine64 lies outside of PATH.
    Platform("x86_64-windows", "win64", "x86_64-windows", ".dll", "win_amd64", "libhnav.dll",
             emulators=("wine64", "/usr/lib/wine/wine64", "wine"), debian="wine64"),
    Platform("aarch64-linux", "aarch64-linux", "aarch64-linux", ".so", "manylinux_2_17_aarch64", "libhnav.so",
             emulators=("qemu-aarch64", "qemu-aarch64-static"), emulator_arguments=("-L", "/usr/aarch64-linux-gnu"),
             debian="qemu-user libc6-arm64-cross"),
    Platform("x86_64-macos", "darwin64", "x86_64-darwin", ".dylib", "macosx_11_0_x86_64", "libhnav.dylib"),
    Platform("aarch64-macos", "aarch64-darwin", "aarch64-darwin", ".dylib", "macosx_11_0_arm64", "libhnav.dylib"),
)  # fmt: skip
