"""The words of the pages: short sentences, nothing said twice, a command at the head; and the check of riddle words."""

import re
from collections import Counter
from pathlib import Path

import pytest

from checkout import TOP
from studies import words

README = TOP / "README.md"
GUIDES = sorted((TOP / "docs").glob("*.md"))
FENCE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
LAYOUT = re.compile(r"^(?:    .*|\||#|<|:::|\$\$|!\[)", re.MULTILINE)


def paragraphs(page: Path) -> list[str]:
    """Running text without code, tables, headings, pictures and formulas; links as their text, an item of a list by itself."""
    text = re.sub(r"^\$\$.*?^\$\$$", "", FENCE.sub("", page.read_text()), flags=re.MULTILINE | re.DOTALL)
    parts = [part for part in re.split(r"\n\s*\n|\n(?=\s*(?:\*|-|\d+\.) )", text) if part.strip() and not LAYOUT.match(part)]
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", re.sub(r"`[^`]*`", "X", part)) for part in parts]
    return [" ".join(part.split()) for part in plain]


def sentences(paragraph: str) -> list[str]:
    return [s for s in re.split(r"(?<=[.:?!;])\s+", paragraph) if len(s.split()) > 1]


def mean_words(texts: list[str]) -> float:
    lengths = [len(s.split()) for text in texts for s in re.split(r"(?<=[.?!])\s+", text) if len(s.split()) > 2]
    return sum(lengths) / len(lengths)


def test_the_sentences_of_the_readme_are_short():
    assert mean_words(paragraphs(README)) <= 17


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_the_first_paragraph_of_a_page_has_short_sentences(page):
    assert mean_words(paragraphs(page)[:1]) <= 17


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_a_page_begins_with_a_command_or_a_few_lines(page):
    """The first block of code stands before the first heading below the title and has the first ten lines to begin in."""
    head = page.read_text().splitlines()[1:16]
    assert any(line.startswith(("    ", "```")) for line in head)


def test_no_sentence_is_said_twice():
    said = Counter(s for page in (README, *GUIDES) for part in paragraphs(page) for s in sentences(part) if len(s.split()) > 9)
    assert [s for s, n in said.items() if n > 1] == []


def test_riddle_words_are_found_in_text_and_in_names():
    assert words.PATTERN.findall("told_sigma; what nobody knows; one that; untold, doubtful") == [
        "told", "nobody", "knows", "one that", "doubtful",
    ]  # fmt: skip


def test_a_folder_above_its_allowance_is_a_finding_with_its_words():
    found = {"docs": Counter(told=2, doubt=1), "c_src/ins": Counter(told=1)}
    (line,) = words.findings(found, {"docs": 2, "c_src/ins": 1})
    assert line.startswith("docs: 3 riddle words, 2 allowed: told 2, doubt 1")


@pytest.mark.parametrize(
    "path, folder",
    [("run", "."), ("docs/ins.md", "docs"), ("python/hnav/io/readers.py", "python/hnav/io"), ("c_src/ins/x/y.cpp", "c_src/ins")],
)
def test_words_are_counted_by_room(path, folder):
    assert words.folder_of(path) == folder
