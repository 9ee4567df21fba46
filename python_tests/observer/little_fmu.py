"""Builds FMUs of little_fmu.c: a mass on a spring that fails on request."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

SOURCE = Path(__file__).with_suffix(".c")
MODES = (
    "sound", "nan_after_1", "error_after_1", "iterates", "terminates", "lies", "one_question", "remembers", "event_at_5",
    "discards_above_3", "fatal_after_1",
)  # fmt: skip

VARIABLES = """
<ScalarVariable name="x" valueReference="0" causality="output" initial="exact"><Real start="1" unit="m"/></ScalarVariable>
<ScalarVariable name="v" valueReference="1" causality="local" initial="exact"><Real start="0"/></ScalarVariable>
<ScalarVariable name="der(x)" valueReference="2"><Real derivative="1"/></ScalarVariable>
<ScalarVariable name="der(v)" valueReference="3"><Real derivative="2"/></ScalarVariable>
<ScalarVariable name="k" valueReference="4" causality="parameter" variability="tunable"><Real start="4"/></ScalarVariable>
<ScalarVariable name="u" valueReference="5" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="d" valueReference="6" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="7" causality="output"><Real unit="m"/></ScalarVariable>
<ScalarVariable name="z" valueReference="8"><Real/></ScalarVariable>
<ScalarVariable name="mode" valueReference="9" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
<ScalarVariable name="on" valueReference="10" causality="parameter" variability="fixed"><Boolean start="true"/></ScalarVariable>
"""

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Little" guid="{{little}}" numberOfEventIndicators="{indicators}">
<{interface} modelIdentifier="little" providesDirectionalDerivative="true" {attributes}/>
<UnitDefinitions>
<Unit name="m"><BaseUnit m="1"/><DisplayUnit name="mm" factor="1000"/></Unit><Unit name="s"><BaseUnit s="1"/></Unit>
</UnitDefinitions>
<ModelVariables>{variables}</ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/><Unknown index="8"/></Outputs>
<Derivatives>{derivatives}</Derivatives></ModelStructure>
</fmiModelDescription>
"""
DERIVATIVES = '<Unknown index="3"/><Unknown index="4"/>'


def compiled(
    folder: Path, once: bool = False, calls_itself: bool = False, crashes_when_freed: bool = False, source: Path = SOURCE,
    define: tuple[str, ...] = (),
) -> Path:  # fmt: skip
    """The binary; the test is skipped where there is no compiler."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    spec = importlib.util.find_spec("fmpy")
    headers = Path(str(spec and spec.origin)).parent / "c-code"
    binary = folder / f"{source.stem}{'_once' * once}.so"
    defined = ["-DONCE"] * once + ["-DCALLS_ITSELF"] * calls_itself + ["-DCRASHES_WHEN_FREED"] * crashes_when_freed
    defined += [f"-D{name}" for name in define]
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", *defined, f"-I{headers}", str(source), "-o", str(binary), "-lm"], check=True)
    return binary


def packed(
    path: Path, binary: Path, *, interface: str = "ModelExchange", attributes: str = "", indicators: int = 0,
    variables: str = VARIABLES, derivatives: str = DERIVATIVES, folder: str = "linux64",
) -> Path:  # fmt: skip
    """An FMU of it."""
    text = DESCRIPTION.format(
        interface=interface, attributes=attributes, indicators=indicators, variables=variables, derivatives=derivatives
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
        archive.write(binary, f"binaries/{folder}/little.so")
    return path
