"""Pages as a browser sees them."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import urllib.request
from pathlib import Path

import pytest

# What a browser would load by itself; a namespace or a link in a comment of plotly.js is neither.
LOADED = re.compile(r"""<(?:script|link|img|iframe|source)\b[^>]*?\b(?:src|href)\s*=\s*["']?(?:https?:)?//""", re.IGNORECASE)


def chromium() -> str:
    """Its path; skips where there is none."""
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        pytest.skip("chromium is not installed: the page is not rendered")
    return found


def browse(page: Path, folder: Path, query: str = "") -> tuple[str, list[str], set[str]]:
    """The document after its scripts ran, the lines on the console, and the addresses that were requested over a network."""
    log = folder / "net.json"
    command = [
        chromium(), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/profile", "--enable-logging=stderr", "--v=0",
        f"--log-net-log={log}", "--virtual-time-budget=30000", "--window-size=1280,2000", "--dump-dom", page.as_uri() + query,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=180)
    # The browser's own services ask without a page: "not an origin".
    initiators = set(re.findall(r'"initiator":"([^"]*)"', log.read_text())) - {"not an origin"}
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line], initiators


class Tab:
    """A page in a headless browser that keeps running: its document and its screenshot. Skips without chromium and websockets."""

    def __init__(self, url: str, folder: Path, width: int = 1600, height: int = 1400):
        client = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
        self._process = subprocess.Popen(
            [chromium(), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/tab", "--remote-debugging-port=0",
             f"--window-size={width},{height}", url], stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert self._process.stderr
        line = next(line for line in self._process.stderr if "DevTools listening on" in line)
        port = re.search(r":(\d+)/", line).group(1)
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as found:
            tab = next(one for one in json.load(found) if one["type"] == "page")
        self._connection = client.connect(tab["webSocketDebuggerUrl"], max_size=None)
        self._socket = self._connection.__enter__()
        self._number = 0
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def call(self, method: str, **params: object) -> dict:
        """The answer of the browser to a call of the Chrome DevTools Protocol."""
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": params}))
        while (answer := json.loads(self._socket.recv(timeout=30))).get("id") != self._number:
            pass
        return answer["result"]

    def value(self, expression: str) -> object:
        """Of an expression in the page."""
        return self.call("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def picture(self, file: Path) -> None:
        """As PNG."""
        file.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))

    def close(self) -> None:
        """Ends the browser."""
        self._connection.__exit__(None, None, None)
        self._process.terminate()
        self._process.wait(timeout=20)
