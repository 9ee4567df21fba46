"""Revision b991a70 of this repository, built once beside this checkout."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

REVISION = "b991a70"
TOP = Path(__file__).resolve().parents[3]
FOLDER = TOP / ".cache" / REVISION
# Written last: what is there is whole.
COMPLETE = "complete"


def old_revision() -> Path:
    """The folder of the old revision with its build. Raises SystemExit when it cannot be made."""
    if (FOLDER / COMPLETE).is_file():
        return FOLDER
    print(f"building revision {REVISION} into {FOLDER}, once", file=sys.stderr)
    FOLDER.mkdir(parents=True, exist_ok=True)
    archive = subprocess.run(["git", "-C", str(TOP), "archive", REVISION], capture_output=True, check=False)
    if archive.returncode:
        raise SystemExit(f"study compare: this clone does not hold revision {REVISION}: {archive.stderr.decode().strip()}")
    subprocess.run(["tar", "-x", "-C", str(FOLDER)], input=archive.stdout, check=True)
    if subprocess.run(["./run", "build"], cwd=FOLDER, check=False).returncode:
        raise SystemExit(f"study compare: revision {REVISION} could not be built in {FOLDER}")
    (FOLDER / COMPLETE).touch()
    return FOLDER
