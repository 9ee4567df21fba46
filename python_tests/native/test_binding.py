"""The declarations that Python works with: those of the C headers, laid out as the compiler lays them out."""

import re
import subprocess
from pathlib import Path

import pytest

from hnav.errors import error_of
from hnav.native.headers import declarations, write_binding
from hnav.native.library import STATUSES, ffi, library

TOP = Path(__file__).resolve().parents[2]
INCLUDE = TOP / "c_src" / "include"


def is_complete_struct(name: str) -> bool:
    try:
        ffi.sizeof(name)
    except ffi.error:  # its fields are the library's own
        return False
    return ffi.typeof(name).kind == "struct"


STRUCTS = [name for name in ffi.list_types()[0] if is_complete_struct(name)]


def members(kind, path: str = "", base: int = 0):
    """(path, offset, size) of every field, also of those of structs inside."""
    for name, field in kind.fields:
        yield path + name, base + field.offset, ffi.sizeof(field.type)
        if field.type.kind == "struct":
            yield from members(field.type, f"{path}{name}.", base + field.offset)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory) -> dict[str, tuple[int, int]]:
    """The compiler's layout: "struct" to (0, size), "struct.field" to (offset, size)."""
    lines = []
    for struct in STRUCTS:
        lines.append(f'printf("{struct} 0 %zu\\n", sizeof({struct}));')
        for path, _, _ in members(ffi.typeof(struct)):
            place = f"offsetof({struct}, {path}), sizeof((({struct}*)0)->{path})"
            lines.append(f'printf("{struct}.{path} %zu %zu\\n", {place});')
    folder = tmp_path_factory.mktemp("layout")
    source, program = folder / "layout.c", folder / "layout"
    body = "\n    ".join(lines)
    source.write_text(f"#include <hnav/hnav.h>\n#include <stdio.h>\nint main(void) {{\n    {body}\n    return 0;\n}}\n")
    subprocess.run(["cc", "-I", str(INCLUDE), str(source), "-o", str(program)], check=True)
    said = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    return {name: (int(offset), int(size)) for name, offset, size in map(str.split, said.splitlines())}


@pytest.mark.parametrize("struct", STRUCTS)
def test_a_struct_is_laid_out_as_the_compiler_does_it(struct, compiled):
    kind = ffi.typeof(struct)
    assert compiled[struct] == (0, ffi.sizeof(kind))
    for path, offset, size in members(kind):
        assert compiled[f"{struct}.{path}"] == (offset, size), path


def test_the_structs_are_all_that_the_headers_define():
    assert {"hnav_ahrs_options", "hnav_attitude", "hnav_ins_error_model", "hnav_reading"} <= set(STRUCTS)
    defined = re.findall(r"^}\s*(hnav_\w+);", declarations(INCLUDE), flags=re.MULTILINE)
    assert sorted(STRUCTS) == sorted(filter(is_complete_struct, defined))


def test_every_function_of_the_headers_is_in_the_library():
    names = set(re.findall(r"\b(hnav_\w+)\s*\(", declarations(INCLUDE)))
    assert len(names) > 80
    missing = [name for name in sorted(names) if not hasattr(library(), name)]
    assert missing == []


def test_the_binding_is_that_of_the_headers(tmp_path):
    """./run build makes it; this one is older than the headers if the two differ."""
    write_binding(INCLUDE, tmp_path / "_hnav.py", "cc")
    made = (tmp_path / "_hnav.py").read_text()
    assert made == (TOP / "python" / "hnav" / "native" / "_hnav.py").read_text()


def test_a_compiler_with_system_headers_of_its_own_reads_the_same(tmp_path):
    (tmp_path / "stddef.h").write_text("#error not this one\n")
    compiler = tmp_path / "cc"
    compiler.write_text(f'#!/bin/sh\nexec cc -isystem "{tmp_path}" "$@"\n')
    compiler.chmod(0o755)
    assert declarations(INCLUDE, str(compiler)) == declarations(INCLUDE)


def test_every_status_but_ok_has_its_error():
    assert STATUSES[0] == "ok" and len(set(STATUSES)) == len(STATUSES)
    for status in STATUSES[1:]:
        assert error_of(status, "text").status == status
    runtime = {status for status in STATUSES[1:] if isinstance(error_of(status, ""), RuntimeError)}
    assert runtime == {
        "out of memory", "late sample", "queue full", "time backwards", "not started", "no data", "solver", "unsupported",
    }  # fmt: skip
