"""MkDocs hook: formulas become MathML when the site is built, so that a page needs no script to show them."""

from __future__ import annotations

import html
import re

from latex2mathml.converter import convert

# What pymdownx.arithmatex leaves of $...$ and $$...$$.
INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)
OPERATOR = re.compile(r"\\operatorname\{(\w+)\}")


def mathml(found: str, display: str = "inline") -> str:
    """The converter has `aligned` under another name only, and draws the name of an operator as a product of italic letters."""
    tex = OPERATOR.sub(r"\\text{\1}", html.unescape(found).replace("{aligned}", "{align*}"))
    return convert(tex, display=display)


def on_page_content(content, page, config, files):
    content = BLOCK.sub(lambda found: f'<div class="formula">{mathml(found[1], "block")}</div>', content)
    return INLINE.sub(lambda found: mathml(found[1]), content)
