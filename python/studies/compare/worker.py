"""One side of the comparison: runs scenarios and leaves the arrays of each in a file.

python -m studies.compare.worker CHECKOUT INPUTS OUTPUTS NAME...
"""

from __future__ import annotations

import sys
import traceback
from pathlib import Path
from typing import Any

import numpy as np

from studies.compare.scenarios import all_scenarios
from studies.compare.side import Side
from studies.compare.verdict import FAILURE


def file_of(folder: Path, name: str) -> Path:
    return folder / (name.replace("/", "~") + ".npz")


def main(checkout: str, inputs: str, outputs: str, *names: str) -> None:
    side, scenarios = Side(Path(checkout), Path(inputs)), dict(all_scenarios(Path(inputs)))
    for name in names:
        found: dict[str, Any]
        try:
            found = scenarios[name](side)
        except Exception:
            found = {FAILURE: np.array(traceback.format_exc())}
        # Under another name until it is whole: the reader of the two sides takes what is there.
        target = file_of(Path(outputs), name)
        partial = target.with_suffix(".part")
        with partial.open("wb") as file:
            np.savez(file, **found)
        partial.rename(target)


if __name__ == "__main__":
    main(*sys.argv[1:])
