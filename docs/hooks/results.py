"""MkDocs hook: each docs/results/NAME.json becomes a page with its tables, and links lead there."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

from mkdocs.structure.files import File

DOCS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(DOCS.parent / "python"))

from studies.results.tables import markdown  # noqa: E402

LINK = re.compile(r"\]\(((?:docs/)?results/\w+)\.json\)")


def on_files(files, config):
    for path in sorted((DOCS / "results").glob("*.json")):
        page = markdown(json.loads(path.read_text(encoding="utf-8")))
        # Links in a result start from docs/, one folder above its page.
        page = re.sub(r"\]\((?!https?:|#)", "](../", page)
        files.append(File.generated(config, f"results/{path.stem}.md", content=page))
    return files


def on_page_markdown(markdown, page, config, files):
    if page.file.src_uri.startswith("results/"):
        page.meta["search"] = {"exclude": True}  # rows of numbers; results.md has the words to find each
    return LINK.sub(r"](\1.md)", markdown)
