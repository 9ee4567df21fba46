"""From a sample on its way to hnav live until its estimate is in a browser's hands: latency, and what is lost on the way.

./run study live [--seconds 60] [--rate 400]

A process of its own runs hnav live with a page and a recording; samples go to it by UDP, a websocket reads what the page would.
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import closing, suppress
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from hnav.cli.console import show
from hnav.cli.words import UsageError
from studies.command import titled_table

LOCAL = "127.0.0.1"
START_S = 20.0
BEGIN_S = 1.0  # of samples: units are found by the first ones, which wait for that


def free_port(kind: socket.SocketKind) -> int:
    """Of this machine, a moment ago."""
    with socket.socket(socket.AF_INET, kind) as here:
        here.bind((LOCAL, 0))
        return int(here.getsockname()[1])


def send(port: int, rate_hz: float, seconds: float, sent_s: dict[float, float]) -> None:
    """A level body that turns slowly; a field in every fourth sample. sent_s: by stamp, the time of time.monotonic()."""
    begin_s, n = time.monotonic(), round(seconds * rate_hz)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        for i in range(n):
            t_s = i / rate_hz
            turn = 0.1 * t_s
            field = f"{2e-5 * np.cos(turn):.6e},{-2e-5 * np.sin(turn):.6e},4.5e-5" if i % 4 == 0 else ",,"
            while (left_s := begin_s + t_s - time.monotonic()) > 0:
                time.sleep(left_s)
            sent_s[t_s] = time.monotonic()
            out.sendto(f"{t_s!r},0,0,0.1,0,0,-9.81,{field}".encode(), (LOCAL, port))


def listen(url: str, seen_s: dict[float, float], ended: threading.Event) -> None:
    """Until the server or the study ends. seen_s: by stamp, when it was first seen."""
    from websockets.sync.client import connect

    with suppress(Exception), connect(url) as page:  # the server goes away at the end
        while not ended.is_set():
            with suppress(TimeoutError):
                state = json.loads(page.recv(timeout=0.5))
                seen_s.setdefault(state["t_s"], time.monotonic())


def command(
    seconds: Annotated[float, typer.Option(min=5.0, help="Of samples")] = 60.0,
    rate: Annotated[float, typer.Option(min=1.0, help="Samples a second")] = 400.0,
) -> None:
    port, page = free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_STREAM)
    sent_s: dict[float, float] = {}
    seen_s: dict[float, float] = {}
    ended = threading.Event()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "live.csv"
        arguments = ["live", f"udp://{LOCAL}:{port}", "--page", "--port", str(page), "--record", str(file)]
        called = [sys.executable, "-m", "hnav", *arguments]
        process = subprocess.Popen(called, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        _wait_for(page)
        listener = threading.Thread(target=listen, args=(f"ws://{LOCAL}:{page}/state", seen_s, ended), daemon=True)
        listener.start()
        send(port, rate, seconds, sent_s)
        time.sleep(0.5)
        ended.set()
        process.terminate()
        _, said = process.communicate(timeout=10)
        rows = len(file.read_text().splitlines()) - 1
    latency_ms = np.array([1e3 * (at_s - sent_s[t_s]) for t_s, at_s in seen_s.items() if t_s >= BEGIN_S])
    heads = "latency median | 99 % | worst | sent | recorded | lost"
    table = titled_table(f"{rate:g} Hz for {seconds:g} s by UDP", "states seen", heads)
    figures = [f"{value:.1f} ms" for value in (np.median(latency_ms), np.quantile(latency_ms, 0.99), latency_ms.max())]
    table.add_row(str(len(latency_ms)), *figures, str(len(sent_s)), str(rows), str(len(sent_s) - rows))
    show(table)
    print(said.splitlines()[-1])


def _wait_for(port: int) -> None:
    """Until the page is served. Raises UsageError after START_S."""
    end_s = time.monotonic() + START_S
    while time.monotonic() < end_s:
        with closing(socket.socket()) as probe:
            if probe.connect_ex((LOCAL, port)) == 0:
                return
        time.sleep(0.05)
    raise UsageError(f"hnav live does not serve its page within {START_S:g} s")
