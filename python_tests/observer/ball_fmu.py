"""Builds FMUs of ball_fmu.c: a bouncing ball that checks the order of calls and fails on request."""

from __future__ import annotations

import zipfile
from pathlib import Path

SOURCE = Path(__file__).with_suffix(".c")
MODES = (
    "sound",
    "iterates",
    "terminates",
    "error_in_event",
    "nan_after_event",
    "endless_times",
    "step_event",
    "grows",
    "lifts",
    "switches",
)

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Ball" guid="{token}" numberOfEventIndicators="{indicators}">
<ModelExchange modelIdentifier="ball" {attributes}/>
<ModelVariables>
<ScalarVariable name="h" valueReference="0" causality="output" initial="exact"><Real start="1"/></ScalarVariable>
<ScalarVariable name="v" valueReference="1" causality="local" initial="exact"><Real start="0"/></ScalarVariable>
<ScalarVariable name="der(h)" valueReference="2"><Real derivative="1"/></ScalarVariable>
<ScalarVariable name="der(v)" valueReference="3"><Real derivative="2"/></ScalarVariable>
<ScalarVariable name="e" valueReference="4" causality="parameter" variability="tunable"><Real start="0.7"/></ScalarVariable>
<ScalarVariable name="kick" valueReference="5" causality="input" variability="discrete"><Real start="0"/></ScalarVariable>
<ScalarVariable name="rests" valueReference="6" variability="discrete"><Real/></ScalarVariable>
<ScalarVariable name="bounces" valueReference="7" variability="discrete"><Real/></ScalarVariable>
<ScalarVariable name="mode" valueReference="8" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/></Outputs>
<Derivatives><Unknown index="3"/><Unknown index="4"/></Derivatives></ModelStructure>
</fmiModelDescription>
"""
SAVES, SERIALIZES = 'canGetAndSetFMUstate="true"', 'canGetAndSetFMUstate="true" canSerializeFMUstate="true"'


def packed(path: Path, binary: Path, attributes: str = SERIALIZES, indicators: int = 1, token: str = "{ball}") -> Path:
    """An FMU of it."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION.format(attributes=attributes, indicators=indicators, token=token))
        archive.write(binary, "binaries/linux64/ball.so")
    return path
