"""Makes the FMU of chain_fmu.c: 64 states and nothing else."""

from __future__ import annotations

import zipfile
from pathlib import Path

from observer.little_fmu import compiled

COUNT = 64
STATE = '<ScalarVariable name="x{i}" valueReference="{i}" causality="output" initial="exact"><Real start="0"/></ScalarVariable>'
RATE = '<ScalarVariable name="der(x{i})" valueReference="{r}"><Real derivative="{of}"/></ScalarVariable>'
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Chain" guid="{{chain}}" numberOfEventIndicators="0">
<ModelExchange modelIdentifier="chain"/>
<ModelVariables>{states}{rates}</ModelVariables>
<ModelStructure><Derivatives>{unknowns}</Derivatives></ModelStructure>
</fmiModelDescription>
"""


def chain_fmu(folder: Path) -> Path:
    """The FMU, x0 to x63."""
    all_of_them = range(COUNT)
    text = DESCRIPTION.format(
        states="".join(STATE.format(i=i) for i in all_of_them),
        rates="".join(RATE.format(i=i, r=COUNT + i, of=i + 1) for i in all_of_them),
        unknowns="".join(f'<Unknown index="{COUNT + i + 1}"/>' for i in all_of_them),
    )
    path = folder / "chain.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
        archive.write(compiled(folder, source=Path(__file__).with_suffix(".c")), "binaries/linux64/chain.so")
    return path
