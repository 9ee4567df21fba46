"""The results: what a command prints becomes JSON and back a table, and the page quotes only what stands there."""

import json
import re

import pytest

from checkout import TOP
from studies.results import study as results
from studies.results.tables import json_text, markdown, read_printed

PAGE = TOP / "docs" / "results.md"
FILES = sorted((TOP / "docs" / "results").glob("*.json"))

PRINTED = """
   errors in deg, of a title
   that is long
┏━━━━━━━━┳━━━━━━━━┓
┃        ┃   rms, ┃
┃ filter ┃    deg ┃
┡━━━━━━━━╇━━━━━━━━┩
│ ahrs   │   1.73 │
├────────┼────────┤
│        │   2.00 │
└────────┴────────┘
worst: 2.00
┌──────┬────────────┐
│ rate │ one P for  │
│      │ all        │
└──────┴────────────┘
"""


def test_what_is_printed_becomes_tables_and_lines():
    assert read_printed(PRINTED) == [
        {"title": "errors in deg, of a title that is long", "columns": ["filter", "rms, deg"], "rows": [["ahrs", "1.73"], ["", "2.00"]]},
        {"title": "worst: 2.00", "columns": [], "rows": [["rate", "one P for all"]]},
    ]  # fmt: skip


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_result_is_whole(file):
    result = json.loads(file.read_text())
    assert json_text(result) == file.read_text()
    tables = [item for item in result["printed"] if isinstance(item, dict)]
    assert all(len(row) == len(table["columns"] or row) for table in tables for row in table["rows"])
    page = re.sub(r"\\(.)", r"\1", markdown(result))
    assert [cell for table in tables for row in table["rows"] for cell in row if cell not in page] == []


def test_a_measurement_writes_its_own_file_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "answer_of", lambda section: PRINTED)
    results.command(["coloured_time"], False, tmp_path)
    (file,) = tmp_path.iterdir()
    made = json.loads(file.read_text())
    assert file.name == "coloured_time.json" and made["printed"] == read_printed(PRINTED)
    assert made["commands"] == ["study ins_error_peer"] and "revision" in made["when"]


def test_each_measurement_has_one_command_that_the_study_can_call():
    assert set(results.QUICK) < results.MEASUREMENTS.keys()
    for result in results.MEASUREMENTS.values():
        (line,) = result["commands"]
        assert line.split()[0] in ("study", "hnav")


def rows_of_the_page() -> list[tuple[str, str]]:
    return re.findall(r"^\| [^|]+ \| ([^|]+) \| \[\w+\]\(results/(\w+)\.json\) \|$", PAGE.read_text(), re.MULTILINE)


def test_the_page_links_every_result():
    assert {name for _, name in rows_of_the_page()} == {file.stem for file in FILES}


@pytest.mark.parametrize("says, name", rows_of_the_page())
def test_a_figure_of_the_page_stands_in_its_table(says, name):
    text = (TOP / "docs" / "results" / f"{name}.json").read_text()
    assert [
        figure for figure in re.findall(r"\d+(?:\.\d+)?(?:e-\d+)?", says) if not re.search(rf"(?<![\d.]){figure}(?![\d])", text)
    ] == []


def test_the_table_of_the_readme_is_that_of_the_results():
    broad = json.loads((TOP / "docs" / "results" / "broad.json").read_text())
    table = next(item for item in broad["printed"] if isinstance(item, dict))
    first = table["columns"].index("total")
    measured = {tuple(row[first : first + 3]) for row in table["rows"]}
    rows = re.findall(r"^\|.+?\| \**([\d.]+)\** \| ([\d.]+) \| ([\d.]+) \|$", (TOP / "README.md").read_text(), re.MULTILINE)
    assert len(rows) == 6
    assert [row for row in rows if row not in measured] == []
