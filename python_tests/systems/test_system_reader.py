"""SSP systems as hnav reads them, every fault named."""

import shutil
import stat
import zipfile
from pathlib import Path

import pytest

from checkout import built_system
from command_line import hnav
from hnav.errors import HnavError
from hnav.fmi.fmus import fmu_path
from hnav.io import archive_room
from hnav.systems.ssp_reader import read_system, system_path
from hnav.systems.structure import Parameter
from made_systems import make_system, parameter_set


@pytest.fixture(scope="module")
def ssp() -> str:
    return built_system("filter")


@pytest.fixture
def pair(ssp, tmp_path) -> Path:
    """Two filters in a folder of their own: the heading of the first aids the second."""
    return make_system(
        tmp_path / "pair",
        {"first": "Hrekf", "second": "Hrekf"},
        [("first.att.heading", "second.aid.heading")],
        {"first.robust.gamma": 2.0},
    )


def test_the_reader_finds_what_the_archive_holds(ssp):
    with read_system(ssp) as system:
        assert list(system.components) == ["hekf", "hrekf"]
        level = {"accel.force[3]": -9.80665, "mag.field[1]": 2e-5, "mag.field[3]": 4.5e-5}
        modes = {"hekf": "off", "hrekf": "kl"}
        expected = {f"{name}.{key}": value for name in modes for key, value in level.items()}
        expected |= {f"{name}.robust.gamma_mode": mode for name, mode in modes.items()}
        assert system.parameters() == expected
        assert len(system.connections) == 18
        assert (system.start_s, system.stop_s) == (0.0, 10.0)
        assert system.connectors["mag_field_1"].unit == "T"


def test_an_input_of_the_system_sets_the_inputs_that_it_feeds(ssp):
    with read_system(ssp) as system:
        system.apply([Parameter("gyro_rate_2", "Real", "0.5", "rad/s")], "caller")
        assert [system.parameters()[f"{name}.gyro.rate[2]"] for name in ("hekf", "hrekf")] == [0.5, 0.5]
        with pytest.raises(HnavError, match=r"caller: hekf.gyro.rate\[2\] is in rad/s, not in deg/s"):
            system.apply([Parameter("gyro_rate_2", "Real", "0.5", "deg/s")], "caller")


def test_an_unpacked_archive_goes_with_the_system(ssp):
    with read_system(ssp) as system:
        fmu = system.components["hekf"].fmu
        assert fmu.is_file()
    assert not fmu.exists()


def test_a_folder_takes_the_fmus_of_the_build(pair):
    with read_system(pair) as system:
        assert system.components["first"].fmu.is_file()
        assert system.parameters() == {"first.robust.gamma": 2.0}
    assert (pair / "SystemStructure.ssd").is_file()


def test_grade_then_scenario_then_caller(pair):
    (pair / "grades").mkdir()
    (pair / "grades" / "fine.ssv").write_text(
        parameter_set({"first.robust.gamma": 3.0, "first.adaptation.adaptation_gain": 0.5, "first.gate.mag_gate_nis": 4.0})
    )
    (pair / "scenario_hard.ssv").write_text(parameter_set({"first.adaptation.adaptation_gain": 0.25, "first.robust.gamma": 2.0}))
    with read_system(pair) as system:
        system.choose("fine", "hard")
        # gamma = 2 is what the SSD binds: the scenario is not about it, and the grade's stays.
        assert system.parameters() == {
            "first.robust.gamma": 3.0,
            "first.adaptation.adaptation_gain": 0.25,
            "first.gate.mag_gate_nis": 4.0,
        }
        system.apply([Parameter("first.robust.gamma_mode", "", "kl"), Parameter("second.gyro.valid", "", "false")], "--set")
        assert system.parameters()["first.robust.gamma_mode"] == "kl"
        assert system.parameters()["second.gyro.valid"] is False


def test_a_name_a_file_and_a_folder_that_are_not_there_are_named(tmp_path, monkeypatch):
    monkeypatch.setenv("HNAV_SYSTEMS", str(tmp_path))
    (tmp_path / "known.ssp").touch()
    for text, said in (
        ("unknown", "there is no system unknown: there are known"),
        (str(tmp_path / "no.ssp"), f"{tmp_path}/no.ssp: file not found"),
        ("no.ssp", "no.ssp: file not found"),
    ):
        with pytest.raises(HnavError) as raised:
            system_path(text)
        assert str(raised.value) == said
    assert system_path("known") == tmp_path / "known.ssp"


def test_an_archive_that_is_none_is_named(tmp_path):
    broken = tmp_path / "broken.ssp"
    broken.write_text("no archive")
    with pytest.raises(HnavError, match="broken.ssp: no SSP archive"):
        read_system(broken)
    empty = tmp_path / "empty.ssp"
    with zipfile.ZipFile(empty, "w") as archive:
        archive.writestr("readme.txt", "nothing")
    with pytest.raises(HnavError, match="empty.ssp/SystemStructure.ssd: file not found"):
        read_system(empty)


def test_an_fmu_that_the_archive_lacks_is_named(ssp, tmp_path):
    lacking = tmp_path / "lacking.ssp"
    with zipfile.ZipFile(ssp) as source, zipfile.ZipFile(lacking, "w") as target:
        target.writestr("SystemStructure.ssd", source.read("SystemStructure.ssd"))
    with pytest.raises(HnavError, match="component hekf: resources/Hrekf.fmu is missing"):
        read_system(lacking)


# --------------------------------------------------------------------------------------------- what an archive may do


def packed(folder: Path, archive: Path, source: str = "resources/Hrekf.fmu", mode: int = 0) -> Path:
    """The system of the folder as an archive with the FMU Hrekf; of its first component the source is this one."""
    text = (folder / "SystemStructure.ssd").read_text().replace('source="resources/Hrekf.fmu"', f'source="{source}"', 1)
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as target:
        target.writestr("SystemStructure.ssd", text)
        entry = zipfile.ZipInfo("resources/Hrekf.fmu")
        entry.external_attr = mode << 16
        target.writestr(entry, fmu_path("Hrekf", 2).read_bytes())
    return archive


@pytest.mark.parametrize(
    "source", ["{beside}", "../../{beside}", "resources/../../Hrekf.fmu", "..", "C:/Hrekf.fmu", "..\\Hrekf.fmu", "/"]
)
def test_an_archive_runs_no_fmu_from_outside(pair, tmp_path, source):
    shutil.copy(fmu_path("Hrekf", 2), tmp_path / "Hrekf.fmu")
    archive = packed(pair, tmp_path / "x.ssp", source.format(beside=tmp_path / "Hrekf.fmu"))
    with pytest.raises(
        HnavError, match="component first: .* lies outside of the archive; --allow-outside takes it, if you trust it"
    ):
        read_system(archive)
    done = hnav("simulate", archive, "--out", tmp_path / "out")
    assert done.returncode == 2 and "lies outside of the archive" in done.stderr and not (tmp_path / "out").exists()


@pytest.mark.parametrize("source", ["Hrekf.fmu", "{folder}/elsewhere/Hrekf.fmu", "../{name}/elsewhere/Hrekf.fmu"])
def test_what_is_allowed_is_found_where_the_archive_lies(pair, tmp_path, source):
    (tmp_path / "elsewhere").mkdir()
    shutil.copy(fmu_path("Hrekf", 2), tmp_path / "elsewhere" / "Hrekf.fmu")
    archive = packed(pair, tmp_path / "x.ssp", source.format(folder=tmp_path, name=tmp_path.name))
    if source == "Hrekf.fmu":  # a path inside the archive without a file
        with pytest.raises(HnavError, match="component first: Hrekf.fmu is missing"):
            read_system(archive, allow_outside=True)
        return
    with read_system(archive, allow_outside=True) as system:
        assert system.components["first"].fmu.resolve() == tmp_path / "elsewhere" / "Hrekf.fmu"
    done = hnav("simulate", archive, "--allow-outside", "--stop", "0.1", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("source", ["http://example.org/Hrekf.fmu", "file:///Hrekf.fmu"])
def test_an_archive_loads_nothing_by_url(pair, tmp_path, source):
    with pytest.raises(HnavError, match=f"component first: {source} is a URL; hnav takes files of the archive only"):
        read_system(packed(pair, tmp_path / "x.ssp", source), allow_outside=True)


def test_an_archive_binds_no_parameters_from_outside(pair, tmp_path):
    ssd = pair / "SystemStructure.ssd"
    (tmp_path / "set.ssv").write_text(parameter_set({"first.robust.gamma": 3.0}))
    binding = f'<ssd:ParameterBinding source="{tmp_path}/set.ssv"/></ssd:ParameterBindings>'
    ssd.write_text(ssd.read_text().replace("</ssd:ParameterBindings>", binding))
    with read_system(pair) as system:  # a folder is the user's own
        assert system.parameters() == {"first.robust.gamma": 3.0}
    archive = packed(pair, tmp_path / "x.ssp")
    with pytest.raises(HnavError, match="a parameter set: .*set.ssv lies outside of the archive"):
        read_system(archive)
    with read_system(archive, allow_outside=True) as system:
        assert system.parameters() == {"first.robust.gamma": 3.0}


def test_links_and_names_that_lead_outside_are_refused_before_anything_is_written(pair, tmp_path, monkeypatch):
    monkeypatch.setattr(zipfile.ZipFile, "extractall", lambda *_: pytest.fail("something was written"))
    with pytest.raises(HnavError, match="its entry resources/Hrekf.fmu is a link or lies outside of the archive"):
        read_system(packed(pair, tmp_path / "link.ssp", mode=stat.S_IFLNK | 0o777))
    archive = packed(pair, tmp_path / "up.ssp")
    with zipfile.ZipFile(archive, "a") as target:
        target.writestr("../up.txt", "")
    with pytest.raises(HnavError, match=r"its entry ../up.txt is a link or lies outside of the archive"):
        read_system(archive)


def test_a_bomb_is_refused_before_anything_is_written(pair, tmp_path, monkeypatch):
    archive = packed(pair, tmp_path / "bomb.ssp")
    monkeypatch.setattr(archive_room, "MOST_BYTES", 20_000_000)
    with read_system(archive):
        pass
    with zipfile.ZipFile(archive, "a", zipfile.ZIP_DEFLATED) as target:
        target.writestr("zeros", bytes(20_000_000))
    assert archive.stat().st_size < 2_000_000
    with monkeypatch.context() as patched:
        patched.setattr(zipfile.ZipFile, "extractall", lambda *_: pytest.fail("something was written"))
        with pytest.raises(HnavError, match="bomb.ssp: unpacks to more than 20 MB; unpack it and name the folder"):
            read_system(archive)
    # Inside an FMU of the archive.
    fmu, nested = pair / "bomb.fmu", tmp_path / "nested.ssp"
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as target:
        target.writestr("zeros", bytes(20_000_000))
    with zipfile.ZipFile(nested, "w") as target:
        target.writestr("SystemStructure.ssd", (pair / "SystemStructure.ssd").read_text())
        target.write(fmu, "resources/Hrekf.fmu")
    with pytest.raises(HnavError, match="component first: resources/Hrekf.fmu: unpacks to more than 20 MB"):
        read_system(nested)


def test_entries_without_number_are_refused(pair, tmp_path, monkeypatch):
    monkeypatch.setattr(archive_room, "MOST_ENTRIES", 40)
    archive = packed(pair, tmp_path / "many.ssp")
    with zipfile.ZipFile(archive, "a") as target:
        for i in range(40):
            target.writestr(f"{i}", "")
    with pytest.raises(HnavError, match="many.ssp: has more than 40 entries"):
        read_system(archive)


def test_an_entry_that_lies_about_its_size_gives_no_more_than_it_says(pair, tmp_path):
    archive = packed(pair, tmp_path / "lie.ssp")
    with zipfile.ZipFile(archive, "a", zipfile.ZIP_DEFLATED) as target:
        target.writestr("zeros", bytes(1_000_000))
    # The size stands in the central directory, 24 bytes behind its mark.
    data = bytearray(archive.read_bytes())
    at = data.rindex(b"PK\x01\x02") + 24
    assert data[at : at + 4] == (1_000_000).to_bytes(4, "little")
    data[at : at + 4] = (10).to_bytes(4, "little")
    archive.write_bytes(data)
    with pytest.raises(HnavError, match="lie.ssp: no SSP archive"):
        read_system(archive)


AID = 'startElement="first" startConnector="att.heading" endElement="second" endConnector="aid.heading"'


@pytest.mark.parametrize(
    "was, becomes, said",
    [
        ("resources/Hrekf.fmu", "resources/Nothing.fmu", "component first: resources/Nothing.fmu is missing"),
        ('endElement="second"', 'endElement="third"', "first.att.heading -> third.aid.heading: there is no element third"),
        ('endConnector="aid.heading"', 'endConnector="aid.height"', "second has no connector aid.height"),
        ('<ssd:Connector name="att.heading"', '<ssd:Connector name="att.height"', "connector first.att.height: Hrekf has no variable att.height"),
        ('name="aid.heading" kind="input"', 'name="aid.heading" kind="output"', "connector second.aid.heading is an output in the SSD and a variable of kind input in the FMU"),
        (AID, AID.replace('startElement="first" startConnector="att.heading"', 'startElement="second" startConnector="aid.heading"'),
         "second.aid.heading -> second.aid.heading: it runs from an input to an input; an output to an input is wanted"),
        ('<ssc:Real unit="rad"/>', '<ssc:Integer/>', "connector first.att.heading is Integer in the SSD and Real in the FMU"),
        ('unit="rad"', 'unit="deg"', "connector first.att.heading is in deg in the SSD and in rad in the FMU"),
        ("first.robust.gamma", "first.robust.gamme", "component first (Hrekf) has no parameter robust.gamme; did you mean robust.gamma?"),
        ("first.robust.gamma", "none.robust.gamma", "none.robust.gamma names no component of system made (first, second)"),
        ('"first.robust.gamma"', '"first.att.heading"', "first.att.heading is a variable of kind output, not a parameter"),
        ('<ssv:Real value="2.0"/>', '<ssv:Integer value="2"/>', "first.robust.gamma is Real, not Integer"),
        ('<ssv:Real value="2.0"/>', '<ssv:Real value="2.0" unit="m"/>', "first.robust.gamma is in 1 (no unit), not in m"),
        ('<ssv:Real value="2.0"/>', '<ssv:Real value="two"/>', "first.robust.gamma = two: a Real is wanted"),
        ("</ssd:Connections>", f"<ssd:Connection {AID}/></ssd:Connections>", "second.aid.heading is already fed by first.att.heading"),
        (f"{AID}/>", f'{AID}><ssc:LinearTransformation factor="2"/></ssd:Connection>', "has a LinearTransformation, which hnav does not do"),
        ("</ssd:Elements>", '<ssd:System name="inner"/></ssd:Elements>', "inner is a System; hnav runs components only"),
        ("</ssd:Elements>", "", "SystemStructure.ssd: cannot be read"),
    ],
)  # fmt: skip
def test_a_faulty_system_is_refused_by_name(pair, was, becomes, said):
    ssd = pair / "SystemStructure.ssd"
    text = ssd.read_text()
    assert was in text
    ssd.write_text(text.replace(was, becomes, 1))
    with pytest.raises(HnavError) as raised:
        read_system(pair)
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


def test_units_of_two_names_agree_when_their_definitions_do(pair):
    ssd = pair / "SystemStructure.ssd"
    renamed = ssd.read_text().replace('unit="rad"', 'unit="radian"')
    units = '<ssd:Units><ssc:Unit name="radian"><ssc:BaseUnit rad="1"{}/></ssc:Unit></ssd:Units></ssd:SystemStructureDescription>'
    ssd.write_text(renamed.replace("</ssd:SystemStructureDescription>", units.format("")))
    with read_system(pair) as system:
        assert system.components["second"].connectors["aid.heading"].unit == "radian"
    ssd.write_text(renamed.replace("</ssd:SystemStructureDescription>", units.format(' factor="2"')))
    with pytest.raises(HnavError, match="in radian in the SSD and in rad in the FMU"):
        read_system(pair)


def test_a_bound_file_that_is_missing_is_named(pair):
    ssd = pair / "SystemStructure.ssd"
    binding = '<ssd:ParameterBinding source="resources/none.ssv"/></ssd:ParameterBindings>'
    ssd.write_text(ssd.read_text().replace("</ssd:ParameterBindings>", binding))
    with pytest.raises(HnavError, match="resources/none.ssv: file not found"):
        read_system(pair)


def test_unknown_choices_and_seeds_without_taker_are_named(pair):
    (pair / "scenario_calm.ssv").write_text(parameter_set({"first.robust.gamma": 2.0}))
    with read_system(pair) as system:
        with pytest.raises(HnavError, match="system made has no scenario wild: it has calm"):
            system.choose(scenario="wild")
        with pytest.raises(HnavError, match="system made has no grade best: it has none"):
            system.choose(grade="best")
        with pytest.raises(HnavError, match="seed = 1: no component of system made has a parameter seed"):
            system.seed(1)
