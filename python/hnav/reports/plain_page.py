"""Pages: one document with its style and its scripts inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from importlib import resources

from hnav import __version__


def text_of(*names: str) -> str:
    """Of files of this package, one after the other."""
    return "\n".join(resources.files("hnav.reports").joinpath(name).read_text(encoding="utf-8") for name in names)


def document(title: str, body: str, script: str = "", before: str = "") -> str:
    """The whole page. body: HTML; script, before: JavaScript that runs behind it and before it."""
    # An empty icon, so that the browser requests none from a server.
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark"><title>hnav · {escape(title)}</title><link rel="icon" href="data:,"><style>{text_of("page.css")}</style>
<script>{before}</script></head><body>
{body}<script>{script}</script></body></html>"""


def heading_of(
    title: str, facts: Mapping[str, object], warnings: Sequence[str] = (), more: str = "", description: str = ""
) -> str:
    """The head of a page: facts by name, and lines of warning; those that begin with note: are no warning. more: HTML."""
    listed = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(str(fact))}</dd></div>" for name, fact in facts.items())
    warned = "".join(f'<p class="{"note" if text.startswith("note:") else "warning"}">{escape(text)}</p>' for text in warnings)
    described = f"<p>{escape(description)}</p>" if description else ""
    return f"<header><h1>{escape(title)}</h1>{described}<dl>{listed}</dl>{warned}{more}</header>"


def plain_page(title: str, facts: Mapping[str, object], main: str, script: str = "") -> str:
    """A page without plots. main: HTML; script: JavaScript."""
    return document(title, f"{heading_of(title, {**facts, 'hnav': __version__})}<main>{main}</main>", script)
