"""The site that ./run docs builds: whole, readable and searchable from disk."""

import re

import pytest

from browser import browse
from checkout import TOP

for module in ("material", "mkdocstrings", "latex2mathml"):
    pytest.importorskip(module, reason="the extra docs is not installed")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    build = pytest.importorskip("mkdocs.commands.build", reason="the extra docs is not installed")
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("docs") / "site"
    build.build(load_config(str(TOP / "mkdocs.yml"), site_dir=str(folder), strict=True))  # strict: a warning ends it
    return folder


def test_pages_load_nothing_from_a_network(site):
    loaded = re.compile(r"<(?:script|link|img|iframe)\b[^>]*?\b(?:src|href)=\"https?://", re.IGNORECASE)
    assert [page.name for page in site.glob("*.html") if loaded.search(page.read_text())] == []
    assert 'href="readme.html' in (site / "navigation.html").read_text()


def test_every_picture_is_there(site):
    pictures = {
        (page.name, src) for page in site.glob("*.html") for src in re.findall(r'<img [^>]*src="([^":]+)"', page.read_text())
    }
    assert len(pictures) > 8
    assert [(page, src) for page, src in sorted(pictures) if not (site / src).is_file()] == []


def test_formulas_are_formulas(site):
    pages = {page.name: page.read_text() for page in site.glob("*.html")}
    assert "<math" in pages["filters.html"] and "<math" in pages["units.html"]
    assert [name for name, text in pages.items() if "arithmatex" in text] == []
    assert [name for name, text in pages.items() if re.search(r"<mi>(?:&(?!#)|\\)", text)] == []  # no LaTeX is left in a formula


def test_the_reference_holds_every_call_of_the_headers(site):
    page = re.sub(r"<[^>]*>", "", (site / "api_c.html").read_text())
    headers = (TOP / "c_src" / "include" / "hnav").glob("*.h")
    calls = {call for header in headers for call in re.findall(r"\b(hnav_\w+)\(", header.read_text())}
    assert len(calls) > 50 and [call for call in sorted(calls) if call not in page] == []


def test_the_reference_holds_the_names_of_the_package(site):
    page = (site / "api_python.html").read_text()
    names = ("FilterObject.push_imu", "Filter.run", "RunBase.report", "Options", "Recording.from_dataframe", "read")
    assert [name for name in names if not re.search(rf'id="hnav\.[\w.]*\b{re.escape(name)}"', page)] == []


def test_the_search_finds_from_disk(site, tmp_path):
    shown, console, initiators = browse(site / "units.html", tmp_path, query="?q=declination")
    assert re.search(r'href="[^"]*navigation\.html[^"]*" class="md-search-result__link"', shown)
    assert console == [] and initiators == set()
