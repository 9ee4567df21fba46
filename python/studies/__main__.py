"""python -m studies NAME ARGS: a study as a command."""

from __future__ import annotations

import sys

from studies.command import main_of

if __name__ == "__main__":
    main_of(sys.argv[1])(sys.argv[2:])
