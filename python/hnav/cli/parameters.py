"""Arguments and options shared by several commands, and the conversion of their text to values."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import is_dataclass
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from hnav.cli.completion import among, option_names
from hnav.cli.words import UsageError
from hnav.filters.options import FILTERS
from hnav.fmi.engines import ENGINES


def _filter(said: str, *names: str) -> Any:
    return typer.Option("--filter", metavar="NAME", help=said, autocompletion=among(*names))


def page_option(said: str) -> Any:
    """An option of a page to write; a name that no browser opens as a page is refused."""
    return typer.Option(metavar="FILE.html", help=said, callback=_page)


def _page(file: Path | None) -> Path | None:
    if file is not None and file.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"{file}: a page is HTML: name it .html")
    return file


FilterName = Annotated[str, _filter("ahrs (real sensors) or hrekf (the paper's)", *FILTERS)]
FilterOrIns = Annotated[
    str, _filter("ahrs (real sensors), hrekf (the paper's) or ins (position, velocity and attitude)", *FILTERS, "ins")
]
Gnss = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Of --filter ins: satellites, pressure or wheels in a file of their own: a table, NMEA, a log of PX4 or ROS",
    ),
]
Workers = Annotated[int, typer.Option(help="Processes on this machine")]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler instead")]
Engine = Annotated[str, typer.Option(help=", ".join(ENGINES), autocompletion=among(*ENGINES))]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="An option of the filter; see hnav options", autocompletion=option_names),
]
MagUnit = Annotated[str | None, typer.Option(metavar="UNIT", help="Of the field: T, uT, nT, G, mG or au (arbitrary)")]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse a recording that is not plausible in any way")]
Force = Annotated[
    bool, typer.Option("--force", help="Go on where unit, axes, sign or a dead sensor make the estimate meaningless")
]
Preset = Annotated[
    str,
    typer.Option(
        help="default or paper; of ins consumer, industrial, tactical or navigation",
        autocompletion=among("default", "paper", "consumer", "industrial", "tactical", "navigation"),
    ),
]
Smooth = Annotated[
    bool,
    typer.Option("--smooth", help="With hindsight: every row from all samples, before and after it (ahrs and ins, engine c)"),
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder with BROAD trials")]
AllowOutside = Annotated[
    bool, typer.Option("--allow-outside", help="Also run FMUs that an .ssp names and does not hold (absolute paths, ../)")
]


def pairs(option: str, texts: list[str] | None) -> dict[str, str]:
    """NAME=VALUE each, to values by name. Raises UsageError."""
    found = {}
    for text in texts or []:
        name, _, value = (part.strip() for part in text.partition("="))
        if not (name and value):
            raise UsageError(f"{option} {text}: write NAME=VALUE")
        found[name] = value
    return found


def parse_settings(texts: list[str] | None) -> dict[str, str]:
    """The values of --set by name. Raises UsageError."""
    return pairs("--set", texts)


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """The command for typer: a parameter whose type is a dataclass becomes the options that are its fields, in its place."""
    hints = get_type_hints(command, include_extras=True)
    groups = {name: get_type_hints(hint, include_extras=True) for name, hint in hints.items() if is_dataclass(hint)}
    shown: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if name not in groups:
            shown.append(parameter.replace(annotation=hints[name]))
        for option, hint in groups.get(name, {}).items():
            shown.append(parameter.replace(name=option, default=getattr(hints[name], option), annotation=hint))

    @functools.wraps(command)
    def called(**given: Any) -> None:
        made = {name: hints[name](**{option: given.pop(option) for option in group}) for name, group in groups.items()}
        command(**made, **given)

    called.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    called.__signature__ = inspect.Signature(shown)  # type: ignore[attr-defined]
    return called
