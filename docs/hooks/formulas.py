"""MkDocs hook: formulas become MathML when the site is built, so that a page needs no script to show them."""

from __future__ import annotations

import html
import re

from latex2mathml.converter import convert

# What pymdownx.arithmatex leaves of $...$ and $$...$$.
INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)


def on_page_content(content, page, config, files):
    content = BLOCK.sub(lambda found: f'<div class="formula">{convert(html.unescape(found[1]), display="block")}</div>', content)
    return INLINE.sub(lambda found: convert(html.unescape(found[1])), content)
