"""The top of the page that `hnav filter FILE --report out.html` writes, as a browser shows it."""

from __future__ import annotations

import io
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from hnav.cli.words import UsageError
from hnav.io.readers import read
from hnav.io.readers.broad import find_trial
from studies.pictures.overview import TRIAL, filtered

WIDTH_PX, HEIGHT_PX = 900, 1150


def browser() -> str | None:
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def draw_page(broad: Path) -> Image.Image:
    """The page about one trial, as a screenshot by a headless browser."""
    program = browser()
    if program is None:
        raise UsageError("the page is drawn by a browser: install chromium")
    recording = read(find_trial(broad, TRIAL))
    with tempfile.TemporaryDirectory() as folder:
        page, picture = Path(folder) / "page.html", Path(folder) / "page.png"
        filtered(recording).report(page, recording)
        command = [
            program, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={folder}/profile",
            "--virtual-time-budget=20000", f"--window-size={WIDTH_PX},{HEIGHT_PX}", f"--screenshot={picture}", page.as_uri(),
        ]  # fmt: skip
        subprocess.run(command, capture_output=True, check=True, timeout=180)
        return Image.open(io.BytesIO(picture.read_bytes()))
