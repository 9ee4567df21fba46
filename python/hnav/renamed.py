"""Names of version 0.1 that have changed, so that a message about an unknown name can give the new one.

renamed.csv has a row for each: kind (option, filter, fmu, variable, component, call, type, python, ...), old name, new name.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from functools import cache

from hnav.places import PACKAGE

TABLE = PACKAGE / "renamed.csv"


@cache
def _new_names() -> dict[tuple[str, str], str]:
    with TABLE.open(newline="") as file:
        return {(row["kind"], row["old"]): row["new"] for row in csv.DictReader(file)}


def new_name(name: str, *kinds: str) -> str | None:
    """Of something of one of these kinds that has changed its name; None for any other."""
    return next((new for kind in kinds if (new := _new_names().get((kind, name)))), None)


def now_called(name: str, *kinds: str) -> str:
    """ ", which is now called NEW" for a name that has changed, to stand behind it in a message; "" for any other."""
    new = new_name(name, *kinds)
    return f", which is now called {new}" if new else ""


def called_in(variables: Iterable[str], name: str) -> str:
    """The same for a name that an FMU does not know: another word, or one that bears its group now, as robust.gamma."""
    word = new_name(name, "option", "variable") or name
    found = [v for v in variables if v == word or v.endswith(f".{word}")]
    return f", which is now called {found[0]}" if len(found) == 1 else now_called(name, "option", "variable")
