"""What a command prints, as data: tables with columns and rows, and the lines around them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

TOP, HEAD_END, BOTTOM = "┏┌", "┡", "└"
Printed = list[str | dict[str, Any]]


def read_printed(text: str) -> Printed:
    """Lines and tables in their order; the line before a table is its title."""
    found: Printed = []
    before: list[str] = []
    lines = iter(text.strip("\n").splitlines())
    for line in lines:
        if line and line[0] in TOP:
            # A title is centred over its table; a long one takes two lines.
            title = before[-2:] if len(before) > 1 and before[-2][0] == before[-1][0] == " " else before[-1:]
            found += [said.strip() for said in before[: len(before) - len(title)]]
            found.append({"title": " ".join(said.strip() for said in title), **_table(line, lines)})
            before = []
        elif line.strip():
            before.append(line)
    return found + [said.strip() for said in before]


def _table(top: str, lines: Any) -> dict[str, Any]:
    columns: list[str] = []
    rows: list[list[str]] = []
    in_head, ruled = top[0] == "┏", False
    for line in lines:
        if line[0] == BOTTOM:
            break
        if line[0] == HEAD_END:
            in_head = False
        elif line[0] in "┃│":
            cells = [cell.strip() for cell in re.split("[┃│]", line)[1:-1]]
            if in_head:
                columns = _joined(columns, cells)
            elif rows and not ruled and not any(cells[:-1]):
                rows[-1] = _joined(rows[-1], cells)  # the last cell of a row that was wrapped
            else:
                rows.append(cells)
            ruled = False
        else:
            ruled = True
    return {"columns": columns, "rows": rows}


def _joined(above: list[str], below: list[str]) -> list[str]:
    return [f"{a} {b}".strip() for a, b in zip(above, below, strict=True)] if above else below


def json_text(result: Mapping[str, Any]) -> str:
    """The result as JSON with one line for each row, so that a new measurement is a readable difference."""
    packed: dict[str, str] = {}

    def mark(value: Any) -> Any:
        if isinstance(value, list) and value and all(isinstance(cell, str) for cell in value):
            key = f"@{len(packed)}@"
            packed[f'"{key}"'] = json.dumps(value, ensure_ascii=False)
            return key
        if isinstance(value, Mapping):
            return {name: value[name] if name in ("notes", "commands") else mark(value[name]) for name in value}
        return [mark(item) for item in value] if isinstance(value, list) else value

    text = json.dumps(mark(result), ensure_ascii=False, indent=1)
    return re.sub(r'"@\d+@"', lambda found: packed[found.group()], text) + "\n"


def markdown(result: Mapping[str, Any]) -> str:
    """The page about a result."""
    parts = [f"# {result['title']}", result["says"], *(f"    ./run {command}" for command in result["commands"])]
    parts += [f"*{result['when']}*"] if result["when"] else []
    parts += result.get("notes", [])
    for item in result["printed"]:
        if isinstance(item, str):
            parts.append(_escaped(item))
        else:
            parts += [f"**{_escaped(item['title'])}**"] if item["title"] else []
            parts.append(_markdown_table(item["columns"], item["rows"]))
    return "\n\n".join(part for part in parts if part) + "\n"


def _markdown_table(columns: list[str], rows: list[list[str]]) -> str:
    head = columns or [""] * len(rows[0])
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(_escaped(cell) for cell in line)} |" for line in lines)


def _escaped(text: str) -> str:
    return re.sub(r"([|*_<])", r"\\\1", text) if not text.startswith("---") else text
