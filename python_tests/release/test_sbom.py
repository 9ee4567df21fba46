"""Lists of third-party components in a release: valid CycloneDX, and the versions are those that the build used."""

import hashlib
import json
import re
import subprocess
import tarfile
import zipfile
from pathlib import Path

import pytest

from checkout import TOP

pytest.importorskip("cyclonedx", reason="cyclonedx-python-lib is not installed")
pytest.importorskip("jsonschema", reason="cyclonedx-python-lib[json-validation] is not installed")

import fmu_archives
import sbom
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

BUILT = TOP / "build-x86_64-linux"


def part(name: str, licence: str = "MIT", archive: str = "") -> sbom.Part:
    return sbom.Part(name, "1.2", licence, "0" * 64, f"pkg:generic/{name}@1.2", "https://example.org/x", "said", archive)


def read(content: bytes) -> dict:
    """The document, after the schema of CycloneDX has found nothing wrong with it."""
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(content.decode()) is None
    return json.loads(content)


def versions(document: dict) -> dict[str, str]:
    return {c["name"]: c["version"] for c in document["components"] if c["type"] == "library"}


@pytest.fixture
def dist_list(dist) -> dict:
    return read(next(dist.glob("hnav-*.cdx.json")).read_bytes())


def test_a_list_is_valid_and_says_name_version_licence_hash_and_origin():
    parts = [part("one", archive="1" * 64), part("two", "Apache-2.0 WITH LLVM-exception")]
    found = read(sbom.document("M.fmu", parts, {"M.so": b"binary"}, {"M.so": ["one"]}))
    one, two = (next(c for c in found["components"] if c["name"] == n) for n in ("one", "two"))
    assert one["version"] == "1.2" and one["licenses"] == [{"license": {"id": "MIT"}}]
    assert one["hashes"] == [{"alg": "SHA-256", "content": "0" * 64}]
    assert one["externalReferences"][0]["hashes"] == [{"alg": "SHA-256", "content": "1" * 64}]
    assert two["licenses"] == [{"expression": "Apache-2.0 WITH LLVM-exception"}]
    assert {"ref": "M.so", "dependsOn": ["one"]} in found["dependencies"]
    assert found["metadata"]["timestamp"] == "2023-11-14T22:13:20+00:00"


def test_equal_parts_give_equal_bytes_and_another_part_another_serial_number():
    one, again, other = (sbom.document("M", [part(a), part(b)]) for a, b in (("a", "b"), ("b", "a"), ("a", "c")))
    assert one == again
    assert read(one)["serialNumber"] != read(other)["serialNumber"]


def test_the_hash_of_a_part_is_what_sha256sum_says(tmp_path):
    (tmp_path / "b").mkdir()
    for name in ("b/x y", "a", "b.h"):
        (tmp_path / name).write_text(name)
    command = "find . -type f | LC_ALL=C sort | xargs -d '\\n' sha256sum | sha256sum"
    said = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert sbom.tree_sha256(tmp_path) == said.split()[0]


def test_a_folder_or_a_header_without_what_is_asked_for_is_named(tmp_path):
    with pytest.raises(SystemExit, match=f"no .* in {tmp_path}"):
        sbom.tree_sha256(tmp_path)
    (tmp_path / "x.h").write_text("#define OTHER 1\n")
    with pytest.raises(SystemExit, match=r"x\.h does not define VERSION"):
        sbom.defined(tmp_path / "x.h", "VERSION")


def test_an_archive_of_sundials_brings_its_name_and_hash(tmp_path):
    include = tmp_path / "built" / "install" / "include" / "sundials"
    include.mkdir(parents=True)
    (include / "sundials_config.h").write_text('#define SUNDIALS_VERSION "9.8.7"\n')
    (tmp_path / "source").mkdir()
    (tmp_path / "source" / "a.c").write_text("")
    assert sbom._sundials(tmp_path / "source", tmp_path / "built").archive == ""
    (tmp_path / "built" / "origin.txt").write_text(f"sundials_9.orig.tar.xz\n{'2' * 64}\n")
    found = sbom._sundials(tmp_path / "source", tmp_path / "built")
    assert (found.version, found.origin, found.archive) == ("9.8.7", "sundials_9.orig.tar.xz", "2" * 64)


def test_every_part_of_a_release_is_listed_with_the_version_that_the_build_used(dist_list):
    if not (BUILT / "parts.json").is_file():
        pytest.skip(f"{BUILT.name} is not there: ./run release makes it")
    found = versions(dist_list)
    assert set(found) == set(sbom.WHEEL)
    where = json.loads((BUILT / "parts.json").read_text())
    macros = Path(where["Eigen"]["folder"], "Eigen", "src", "Core", "util", "Macros.h").read_text()
    numbers = dict(re.findall(r"#define EIGEN_(WORLD|MAJOR|MINOR)_VERSION (\d+)", macros))
    assert found["Eigen"] == "{WORLD}.{MAJOR}.{MINOR}".format(**numbers)
    installed = next((BUILT / "sundials" / "install").glob("**/SUNDIALSConfigVersion.cmake")).read_text()
    assert found["SUNDIALS"] == re.search(r'set\(PACKAGE_VERSION "(\S+)"\)', installed)[1]
    pinned = (TOP / "release" / "requirements.txt").read_text()
    assert found["compiler_rt"] == re.search(r"^ziglang==(\S+)", pinned, re.M)[1]


def test_every_released_fmu_lists_its_parts_and_its_binaries(dist):
    for version in (2, 3):
        for fmu in dist.glob(f"fmi{version}/*.fmu"):
            with zipfile.ZipFile(fmu) as archive:
                found = read(archive.read(fmu_archives.SBOM))
                # An observer holds its plant, with binaries too.
                binaries = {
                    n: hashlib.sha256(archive.read(n)).hexdigest()
                    for n in archive.namelist()
                    if n.startswith(("binaries/", "resources/plant/binaries/"))
                }
                assert {"documentation/licenses/mingw-w64.txt", "documentation/licenses/libc++.txt"} <= set(archive.namelist())
            assert set(versions(found)) == set(sbom.FMU[version]), fmu.name
            assert {c["name"]: c["hashes"][0]["content"] for c in found["components"] if c["type"] == "file"} == binaries, (
                fmu.name
            )


def test_the_wheel_and_the_packages_bring_their_lists(dist, dist_list):
    with zipfile.ZipFile(next(dist.glob("hnav-*.whl"))) as wheel:
        listed = [n for n in wheel.namelist() if n.endswith(".dist-info/sboms/hnav.cdx.json")]
        found = read(wheel.read(listed[0]))
        record = wheel.read(next(n for n in wheel.namelist() if n.endswith("RECORD"))).decode()
    assert len(listed) == 1 and listed[0] in record and set(versions(found)) == set(sbom.WHEEL)
    with tarfile.open(next(dist.glob("libhnav-dev*.tar.gz"))) as package:
        name = next(n for n in package.getnames() if n.endswith("share/doc/hnav/hnav.cdx.json"))
        found = read(package.extractfile(name).read())
    assert versions(found) == {n: v for n, v in versions(dist_list).items() if n in sbom.LIBRARY}


def test_every_file_of_dist_is_listed_and_has_its_sum(dist, dist_list):
    files = {str(p.relative_to(dist)): hashlib.sha256(p.read_bytes()).hexdigest() for p in dist.rglob("*") if p.is_file()}
    listed = {c["name"]: c["hashes"][0]["content"] for c in dist_list["components"] if c["type"] == "file"}
    own = next(dist.glob("hnav-*.cdx.json")).name
    sums = {name: h for h, name in (line.split("  ") for line in (dist / "SHA256SUMS").read_text().splitlines())}
    assert sums == {n: h for n, h in files.items() if n != "SHA256SUMS"}
    assert listed == {n: h for n, h in sums.items() if n != own}
