"""Pages as a browser sees them."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

# What a browser would load by itself; a namespace or a link in a comment of plotly.js is neither.
LOADED = re.compile(r"""<(?:script|link|img|iframe|source)\b[^>]*?\b(?:src|href)\s*=\s*["']?(?:https?:)?//""", re.IGNORECASE)


def browse(page: Path, folder: Path, query: str = "") -> tuple[str, list[str], set[str]]:
    """The document after its scripts, the lines on the console, and who asked for what goes over a network."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("chromium is not installed: the page is not rendered")
    log = folder / "net.json"
    command = [
        chromium, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/profile", "--enable-logging=stderr", "--v=0",
        f"--log-net-log={log}", "--virtual-time-budget=30000", "--window-size=1280,2000", "--dump-dom", page.as_uri() + query,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=180)
    # The browser's own services ask without a page: "not an origin".
    initiators = set(re.findall(r'"initiator":"([^"]*)"', log.read_text())) - {"not an origin"}
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line], initiators
