"""docs/results.md as sections: split, one replaced, joined again."""

from __future__ import annotations

import re

HEADING = re.compile(r"^## (.*)$", re.MULTILINE)


def _trimmed(body: str) -> str:
    """Without empty lines around; a first line that is indented is a command and stays so."""
    return body.strip("\n").rstrip()


class Page:
    """A page whose sections are known by their headings, in their order."""

    def __init__(self, text: str):
        parts = HEADING.split(text)
        self.head = parts[0].rstrip()
        self.sections = {title.strip(): _trimmed(body) for title, body in zip(parts[1::2], parts[2::2])}

    def put(self, title: str, body: str) -> None:
        """Replaces the section, or adds it at the end."""
        self.sections[title] = _trimmed(body)

    def text(self) -> str:
        return "\n\n".join([self.head, *(f"## {title}\n\n{body}" for title, body in self.sections.items())]) + "\n"


def measured(says: str, command: str, when: str, printed: str) -> str:
    """The body of a section. when: date, machine and revision."""
    return f"{says}\n\n    ./run {command}\n\n*{when}*\n\n```text\n{printed.strip()}\n```"
