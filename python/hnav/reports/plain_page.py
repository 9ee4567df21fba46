"""A page without plots: one document with its style and its scripts inside."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from importlib import resources

from hnav import __version__


def text_of(*names: str) -> str:
    """Of files of this package, one after the other."""
    return "\n".join(resources.files("hnav.reports").joinpath(name).read_text(encoding="utf-8") for name in names)


def plain_page(title: str, facts: Mapping[str, object], main: str, script: str = "") -> str:
    """The document. main: HTML; script: JavaScript."""
    listed = "".join(
        f"<div><dt>{escape(name)}</dt><dd>{escape(str(fact))}</dd></div>" for name, fact in {**facts, "hnav": __version__}.items()
    )
    scripts = f"<script>{script}</script>" if script else ""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="color-scheme" content="light dark"><title>hnav · {escape(title)}</title><link rel="icon" href="data:,">'
        f"<style>{text_of('page.css')}</style></head><body><header><h1>{escape(title)}</h1><dl>{listed}</dl></header>"
        f"<main>{main}</main>{scripts}</body></html>\n"
    )
