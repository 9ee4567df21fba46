"""Which mutants there are, and a copy of the sources that holds them all behind a switch."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable
from pathlib import Path

from studies.mutants.sites import Mutant, Piece, mutants_of

ROOMS = (
    *("maths", "hybrid", "signals", "estimation"),
    *("attitude/common", "attitude/ahrs", "attitude/hrekf", "ins", "ins_error", "observer"),
)
SWITCH = Path(__file__).parent / "switch.hpp"
COPIED = ("CMakeLists.txt", "LICENSE", "README.md", "c_src", "cmake")


def room_of(mutant: Mutant) -> str:
    return mutant.path.rsplit("/", 1)[0]


def sources(checkout: Path, rooms: Iterable[str]) -> list[str]:
    """Relative to c_src."""
    return sorted(
        path.relative_to(checkout / "c_src").as_posix() for room in rooms for path in (checkout / "c_src" / room).glob("*.[ch]pp")
    )


def chosen(checkout: Path, count: int, rooms: Iterable[str] = ROOMS, draw: int = 0) -> list[Mutant]:
    """About so many of all that these rooms have: of each file in proportion to the root of what it offers, at least one.

    draw: another number, other mutants.
    """
    offered = {path: mutants_of(path, (checkout / "c_src" / path).read_bytes()) for path in sources(checkout, rooms)}
    scale = count / sum(math.sqrt(len(all_of)) for all_of in offered.values())
    return [
        mutant
        for all_of in offered.values()
        for mutant in sample(all_of, math.ceil(scale * math.sqrt(len(all_of)) - 0.5) or 1, draw)
    ]


def sample(mutants: list[Mutant], count: int, draw: int = 0) -> list[Mutant]:
    """The first of each kind by their names, permuted by draw, then the second of each, until there are so many; in the
    order of the text."""
    by_kind: dict[str, int] = {}
    ranks: dict[str, tuple[int, int]] = {}
    permutation = zlib.crc32(str(draw).encode()) if draw else 0
    for place, mutant in enumerate(sorted(mutants, key=lambda m: int(m.name, 16) ^ permutation)):
        by_kind[mutant.kind] = by_kind.get(mutant.kind, 0) + 1
        ranks[mutant.name] = (by_kind[mutant.kind], place)
    return sorted(sorted(mutants, key=lambda m: ranks[m.name])[:count], key=lambda m: m.begin)


def mutated(source: bytes, mutants: list[Mutant]) -> bytes:
    """The source with these mutants of its own."""
    if not mutants:
        return source

    def text(begin: int, end: int, around: Mutant | None) -> str:
        inside = [m for m in mutants if begin <= m.begin and m.end <= end and m is not around]
        out = []
        for m in sorted((m for m in inside if not any(holds(other, m) for other in inside)), key=lambda m: m.begin):
            out += [source[begin : m.begin].decode(), *(piece_of(m, piece) for piece in m.pieces)]
            begin = m.end
        return "".join([*out, source[begin:end].decode()])

    def piece_of(m: Mutant, piece: Piece) -> str:
        return piece.replace("{k}", f"0x{m.name}") if isinstance(piece, str) else text(*piece, m)

    return text(0, len(source), None).encode()


def holds(outer: Mutant, inner: Mutant) -> bool:
    return outer is not inner and outer.begin <= inner.begin and inner.end <= outer.end


def write_copy(checkout: Path, folder: Path, mutants: Iterable[Mutant]) -> None:
    """The sources in the folder. What is the same as before keeps its time, for the build."""
    by_path: dict[str, list[Mutant]] = {}
    for mutant in mutants:
        by_path.setdefault(f"c_src/{mutant.path}", []).append(mutant)
    present = set()
    for name in COPIED:
        top = checkout / name
        for path in [top] if top.is_file() else sorted(p for p in top.rglob("*") if p.is_file()):
            relative = path.relative_to(checkout)
            present.add(folder / relative)
            put(folder / relative, mutated(path.read_bytes(), by_path.get(relative.as_posix(), [])))
    for stale in [p for p in folder.rglob("*") if p.is_file() and p not in present]:
        stale.unlink()


def put(path: Path, data: bytes) -> None:
    if not path.is_file() or path.read_bytes() != data:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
