"""A page that shows an estimate while it runs: served by this process, for browsers of this machine unless another host is asked for.

    with LivePage("udp://127.0.0.1:5005", "ahrs") as page:
        page.show({"t_s": ..., "q": ..., ...})          # see live.js for what it draws

A browser is sent the newest state at most every INTERVAL_S; a slow reader misses states in between, and holds nothing back.
"""

from __future__ import annotations

import json
import threading
import time
from contextlib import suppress
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

from hnav.errors import HnavValueError
from hnav.reports.plain_page import plain_page, text_of

LOCAL = "127.0.0.1"
PORT = 8765
INTERVAL_S = 0.02
"""Interval in s between two states for a browser: every second frame of a screen."""
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'"


class LivePage:
    """A server of one page and of its websocket /state.

    host, port: where it listens; port 0 is any that is free. Raises HnavValueError where that cannot be, and without the package websockets.
    """

    def __init__(self, source: str, filter: str, host: str = LOCAL, port: int = PORT):
        try:
            from websockets.sync.server import serve
        except ImportError:
            raise HnavValueError(
                "option", "the page needs websockets: python -m pip install websockets (the extra 'live')"
            ) from None
        self._html = plain_page("live", {"source": source, "filter": filter}, MAIN, text_of("screen.js", "body.js", "live.js"))
        self._fresh, self._state, self._number, self._ended = threading.Condition(), "", 0, False
        try:
            self._server = serve(self._send_states, host, port, process_request=self._answer, compression=None)
        except OSError as error:
            text = (error.strerror or str(error)).lower()
            raise HnavValueError("option", f"the page cannot be served at {host}:{port}: {text}") from None
        self.host, self.port = host, int(self._server.socket.getsockname()[1])
        self._names = {f"{name}:{self.port}" for name in {host, LOCAL, "localhost"}}

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{self.host}:{self.port}/"

    def __enter__(self) -> LivePage:
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        with self._fresh:
            self._ended = True
            self._fresh.notify_all()
        self._server.shutdown()

    def show(self, state: dict[str, Any]) -> None:
        """The newest state, of plain values."""
        text = json.dumps(state)
        with self._fresh:
            self._state, self._number = text, self._number + 1
            self._fresh.notify_all()

    def _answer(self, connection: Any, request: Any) -> Any:
        """Answers with the page or the websocket; refuses requests that come from another site."""
        host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
        foreign = self.host == LOCAL and host not in self._names
        if foreign or (origin is not None and urlsplit(origin).netloc != host):
            return connection.respond(HTTPStatus.FORBIDDEN, "another site may not read this page\n")
        if request.path == "/state":
            return None
        if request.path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "there is one page: /\n")
        response = connection.respond(HTTPStatus.OK, self._html)
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "text/html; charset=utf-8"
        response.headers["Content-Security-Policy"] = POLICY
        return response

    def _send_states(self, connection: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        sent = 0
        with suppress(ConnectionClosed):
            while True:
                with self._fresh:
                    self._fresh.wait_for(lambda sent=sent: self._ended or self._number != sent)  # type: ignore[misc]
                    if self._ended:
                        return
                    text, sent = self._state, self._number
                connection.send(text)
                time.sleep(INTERVAL_S)


MAIN = (
    '<p class="warning" id="lost" hidden></p>'
    '<section id="body"><h2>The body</h2><p class="note">Seen from the south-west and above; drag to look from elsewhere. The arrow is the '
    'body\'s x axis, the shadow its heading.</p><div class="body"><canvas id="body-canvas" role="img" aria-label="The body now"></canvas>'
    '<output id="body-says"></output></div></section>'
    '<section id="heading"><h2>Heading</h2><p class="note">The last 30 s; the band is one sigma on either side.</p>'
    '<div class="body"><canvas id="heading-canvas" role="img" aria-label="Heading over time"></canvas></div></section>'
    '<section id="state"><h2>State</h2><div class="scroll"><table class="words" id="state-rows"></table></div></section>'
    '<section id="counts"><h2>Counts</h2><p class="note">Of lines since the begin.</p><dl id="count-rows"></dl>'
    '<pre class="figures" id="notes" style="white-space: pre-wrap"></pre></section>'
)
