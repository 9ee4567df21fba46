"""The panel of the report with a body that turns: attitudes for body_player.js, which draws them on a canvas."""

from __future__ import annotations

import base64
import json
from html import escape

import numpy as np

from hnav.reports.attitude_panels import has_filters, truth_name
from hnav.reports.colours import INK
from hnav.reports.panels import colour_of, panel
from hnav.reports.plain_page import text_of
from hnav.systems.results import Run
from hnav.systems.run_views import estimates, truth_q_nb

RECOMMENDED = "ahrs"  # is shown first
ATTITUDES = 3000  # of each filter: more than a slider has places
UNIT = 32767  # in the data: to 0.002 deg


def _base64(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(values.astype(kind).tobytes()).decode()


def _attitudes(q_nb: np.ndarray, rows: np.ndarray) -> str:
    return _base64(np.round(UNIT * np.nan_to_num(q_nb[rows])), "<i2")  # all zero where there is none


@panel("body", "The body", "Seen from the south-west and above; drag to look from elsewhere. The arrow is the body's x axis, the shadow "
       "its heading. Filled: the estimate. Outlined: what it is compared with.", has_filters)  # fmt: skip
def body_panel(run: Run) -> str:
    rows = np.linspace(0, len(run.t_s) - 1, min(len(run.t_s), ATTITUDES)).round().astype(int)
    filters = sorted(estimates(run), key=lambda estimate: estimate.name != RECOMMENDED)
    tracks = [{"name": e.name, "colour": colour_of(run, e.name), "q": _attitudes(e.q_nb, rows)} for e in filters]
    truth = truth_q_nb(run)
    data = {
        "t": _base64(run.t_s[rows], "<f4"), "unit": UNIT, "frame": run.about.get("frame", "ned"), "tracks": tracks,
        "truth": None if truth is None else {"name": truth_name(run), "colour": INK, "q": _attitudes(truth, rows)},
    }  # fmt: skip
    said = json.dumps(data).replace("</", r"<\/")
    choices = "".join(f'<option value="{i}">{escape(str(track["name"]))}</option>' for i, track in enumerate(tracks))
    chooser = f'<label>filter <select id="body-filter">{choices}</select></label>' if len(tracks) > 1 else ""
    speeds = "".join(f"<option value={speed}>{speed}×</option>" for speed in (1, 2, 5, 20, 100))
    return (
        '<div class="body"><canvas id="body-canvas" role="img" aria-label="The body at the chosen time"></canvas>'
        '<output id="body-says"></output></div><div class="controls"><button id="body-play" type="button">play</button>'
        f'<input id="body-time" type="range" min="0" max="{len(rows) - 1}" value="0" step="1" aria-label="time">'
        f'<label>speed <select id="body-speed">{speeds}</select></label>{chooser}</div>'
        f'<script type="application/json" id="body-data">{said}</script>'
        # A module waits until the page is there, and page.js has run.
        f'<script type="module">{text_of("body.js", "body_player.js")}</script>'
    )
