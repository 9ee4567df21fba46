"""The page of results, rewritten section by section."""

from checkout import TOP
from studies.results.page import Page


def test_what_is_not_measured_again_stays_as_it_is():
    text = (TOP / "docs" / "results.md").read_text()
    assert Page(text).text() == text


def test_a_section_may_begin_with_a_command():
    page = Page("# Results\n\n## One\n\ntext\n")
    page.put("Two", "\n    ./run study two\n\nsays\n")
    assert page.text().endswith("## Two\n\n    ./run study two\n\nsays\n")
