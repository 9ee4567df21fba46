"""The machines that a release is for, by the name of their toolchain file in cmake/toolchains."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Platform:
    """Where an FMU of each version keeps its binary, and what starts a program of the platform on this machine.

    fmi2: None where FMI 2 has no name for the platform. runner: empty on the machine's own platform.
    """

    name: str
    fmi2: str | None
    fmi3: str
    suffix: str
    runner: tuple[str, ...] = ()
    runner_package: str = ""

    def folder(self, version: int) -> str | None:
        return self.fmi2 if version == 2 else self.fmi3


PLATFORMS = (
    Platform("x86_64-linux", "linux64", "x86_64-linux", ".so"),
    Platform("x86_64-windows", "win64", "x86_64-windows", ".dll", ("/usr/lib/wine/wine64",), "wine64"),
    Platform("aarch64-linux", None, "aarch64-linux", ".so", ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"), "qemu-user and libc6-arm64-cross"),
)
