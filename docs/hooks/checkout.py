"""MkDocs hook: what lies outside docs/ and is linked from there becomes part of the site.

The Markdown files must read well in the checkout, where links are relative to the file, and in the site, where only docs/
exists. So README, CHANGELOG and SECURITY are pages of their own, and a source file that a page links is copied as text.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from mkdocs.structure.files import File

TOP = Path(__file__).resolve().parents[2]
PAGES = {"README.md": "readme.md", "CHANGELOG.md": "changelog.md", "SECURITY.md": "security.md"}
# [text](path#anchor), of a path inside the checkout; a picture may stand in for the text.
LINK = re.compile(r"\[(?P<text>[^\[\]]*)\]\((?P<path>[^)#\s:]+)(?P<anchor>#[^)\s]*)?\)")
FENCE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)


def target_in_site(link: str, folder: str) -> tuple[str, Path | None]:
    """(link in the site, file to copy or None) of a relative link in a page of `folder` of the checkout.

    A folder is its README; the link is "" where there is no such file.
    """
    path = posixpath.normpath(posixpath.join(folder, link))
    if path in PAGES:
        return PAGES[path], None
    if path.startswith("docs/"):
        return path.removeprefix("docs/"), None
    file = TOP / path
    if file.is_dir():
        file = file / "README.md"
        path += "/README.md"
    return (f"checkout/{path}.txt", file) if file.is_file() else ("", None)


def outside_code(markdown: str, change) -> str:
    """markdown with change(text) applied everywhere but in fenced blocks."""
    parts, end = [], 0
    for fence in FENCE.finditer(markdown):
        parts += [change(markdown[end : fence.start()]), fence.group()]
        end = fence.end()
    return "".join([*parts, change(markdown[end:])])


def on_files(files, config):
    copies: dict[str, Path] = {}

    def collect(text: str, folder: str) -> None:
        for link in LINK.finditer(text):
            target, source = target_in_site(link["path"], folder)
            if source is not None:
                copies[target] = source

    for name, page in PAGES.items():
        text = (TOP / name).read_text(encoding="utf-8")
        collect(text, "")
        files.append(File.generated(config, page, content=text))
    for page in (TOP / "docs").glob("*.md"):
        collect(page.read_text(encoding="utf-8"), "docs")
    for file in files:
        if file.src_uri.startswith("results/") and file.src_uri.endswith(".md"):
            collect(file.content_string, "docs/results")
    for target, source in copies.items():
        files.append(File.generated(config, target, content=source.read_text(encoding="utf-8")))
    return files


def on_page_markdown(markdown, page, config, files):
    here = posixpath.dirname(page.file.src_uri)
    folder = "" if page.file.src_uri in PAGES.values() else posixpath.join("docs", here).rstrip("/")

    def rewrite(match: re.Match) -> str:
        target, _ = target_in_site(match["path"], folder)
        if not target and (TOP / folder / match["path"]).is_dir():
            return match["text"]  # a folder that explains nothing has no page
        # What does not exist stays as it was written, for MkDocs to name it.
        link = posixpath.relpath(target, here or ".") if target else match["path"]
        return f"[{match['text']}]({link}{match['anchor'] or ''})"

    return outside_code(markdown, lambda text: LINK.sub(rewrite, text))
