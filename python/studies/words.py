"""Counts words that are riddles in a technical text, by folder: ./run study words.

A filter measures, estimates, rejects. `./run check` fails when a folder has more of these
words than words_allowed.json permits; `--write` lowers the allowances to the present counts and never raises one.
"""

from __future__ import annotations

import json
import re
import subprocess
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from hnav.places import CHECKOUT as TOP

ALLOWED = Path(__file__).with_name("words_allowed.json")
RIDDLES = r"told|tells?|telling|lately|doubt\w*|nobody|knows|believe[sd]?|reckon\w*|one that|anew"
# In names too: told_sigma counts, untold does not.
PATTERN = re.compile(rf"(?<![A-Za-z])(?:{RIDDLES})(?![A-Za-z])", re.IGNORECASE)
READ = {".c", ".cpp", ".h", ".hpp", ".html", ".md", ".py", ".toml", ""}
NOT_READ = re.compile(r"c_src/fuzz/corpus/|python/studies/words\.py|python_tests/docs/test_words\.py|LICENSE")


def folder_of(path: str) -> str:
    """The room of a file: c_src/ins, python/hnav/io, docs; "." for files at the top."""
    parts = Path(path).parts[:-1]
    return "/".join(parts[: 3 if parts[:2] == ("python", "hnav") else 2]) or "."


def sources() -> list[str]:
    """Files of the checkout, relative to its top."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=TOP, capture_output=True, text=True, check=True
    )
    return [p for p in listed.stdout.splitlines() if Path(p).suffix in READ and not NOT_READ.search(p) and (TOP / p).is_file()]


def counts() -> dict[str, Counter[str]]:
    """Riddle words by folder."""
    found: dict[str, Counter[str]] = {}
    for path in sources():
        words = PATTERN.findall((TOP / path).read_text(encoding="utf-8", errors="replace"))
        found.setdefault(folder_of(path), Counter()).update(word.lower() for word in words)
    return found


def findings(found: dict[str, Counter[str]], allowed: dict[str, int]) -> list[str]:
    """One line for each folder with more riddle words than are allowed."""
    return [
        f"{folder}: {words.total()} riddle words, {allowed.get(folder, 0)} allowed: "
        + ", ".join(f"{word} {n}" for word, n in words.most_common())
        + "; use the field's verb and name the quantity (measure, estimate, reject, hold, the stated sigma)"
        for folder, words in sorted(found.items())
        if words.total() > allowed.get(folder, 0)
    ]


def command(write: Annotated[bool, typer.Option("--write", help="lower the allowances to the present counts")] = False) -> None:
    """Counts riddle words by folder; exit code 1 where there are more than allowed."""
    found, allowed = counts(), json.loads(ALLOWED.read_text(encoding="utf-8"))
    if write:
        lowered = {folder: min(n, found.get(folder, Counter()).total()) for folder, n in allowed.items()}
        ALLOWED.write_text(json.dumps({k: n for k, n in sorted(lowered.items()) if n}, indent=1) + "\n", encoding="utf-8")
        return
    lines = findings(found, allowed)
    print("\n".join(lines or [f"{sum(words.total() for words in found.values())} riddle words, none above its allowance"]))
    if lines:
        raise typer.Exit(1)
