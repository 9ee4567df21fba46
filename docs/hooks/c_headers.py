"""MkDocs hook: the page api_c.md goes on with the C headers, a heading for each section, comments as text above what they explain."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path

INCLUDE = Path(__file__).resolve().parents[2] / "c_src" / "include" / "hnav"
HEADERS = ("hnav", "filter", "ahrs", "hrekf", "ins", "ins_error", "observer", "calibration", "simulation", "types")

# /* ---- title, which may begin a comment that goes on, or end at once.
SECTION = re.compile(r"^/\* -{20,} ?(?P<title>[^\n*]*?)(?: \*/)?$", re.MULTILINE)
HEAD = re.compile(r"\A/\*(?P<text>.*?)\*/\n", re.DOTALL)
# What the compiler needs and no reader looks for.
FRAME = re.compile(
    r"^#ifdef __cplusplus\n[^#]*#endif\n|^#(?:ifndef|define|endif)\b[^\n]*HNAV_\w*H\b[^\n]*\n|^#include [^\n]*\n", re.MULTILINE
)


def unwrapped(comment: str) -> str:
    """The text of a block comment without the stars of its lines."""
    return "\n".join(re.sub(r"^ \* ?| \*$|^ {3}(?=\S)", "", line) for line in comment.splitlines()).strip()


def as_prose(text: str) -> str:
    """Comment text as Markdown: a paragraph with indented lines stays as it is laid out, names with _ are no emphasis."""
    parts = []
    for paragraph in re.split(r"\n{2,}", text):
        if re.search(r"^ ", paragraph, re.MULTILINE):
            parts.append(f"```text\n{textwrap.dedent(paragraph)}\n```")
        else:
            parts.append(re.sub(r"([_*<])", r"\\\1", paragraph))
    return "\n\n".join(parts)


def code(text: str) -> str:
    text = re.sub(r"\n{3,}", "\n\n", text).strip()
    return f"```c\n{text}\n```" if text else ""


def section(title: str, body: str) -> str:
    """One section of a header. A title line without an end of comment goes on as prose."""
    prose = ""
    if title.endswith("\n"):
        prose, _, body = body.partition("*/")
        prose = as_prose(unwrapped(prose))
    return "\n\n".join(part for part in (f"### {title.strip().capitalize()}", prose, code(body)) if part)


def header_page(name: str) -> str:
    """A header as Markdown."""
    text = (INCLUDE / f"{name}.h").read_text(encoding="utf-8")
    head = HEAD.match(text)
    assert head is not None, f"{name}.h begins with no comment"
    text = FRAME.sub("", text[head.end() :])
    marks = list(SECTION.finditer(text))
    parts = [f"## hnav/{name}.h", as_prose(unwrapped(head["text"])), code(text[: marks[0].start()] if marks else text)]
    ends = [*(mark.start() for mark in marks[1:]), len(text)]
    for mark, end in zip(marks, ends if marks else (), strict=True):
        goes_on = not mark.group().endswith("*/")
        body = text[mark.end() : end]
        parts.append(section(mark["title"] + ("\n" if goes_on else ""), body))
    return "\n\n".join(part for part in parts if part)


def on_page_markdown(markdown, page, config, files):
    if page.file.src_uri != "api_c.md":
        return None
    return "\n\n".join([markdown, *map(header_page, HEADERS)])
