"""A file of records that only grows: whole records are read, an unfinished one is left out, other files are refused."""

import math
import os
import signal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hnav.errors import HnavError
from hnav.io.outputs import OutputError
from hnav.io.record_file import RecordFile
from small_files import no_longer_than

HEAD = {"kind": "numbers", "step": 0.1}
RECORDS = [[0, [{"a": 0.1 + 0.2, "b": "ä\n"}]], [2, []], [1, [None, 1e-300, -0.0]]]


def filled(path, records=RECORDS):
    with RecordFile(path, HEAD) as file:
        for record in records:
            assert file.add(record) == record
    return path


def test_records_come_back_bit_for_bit_and_more_are_added(tmp_path):
    path = filled(tmp_path / "new" / "x")
    with RecordFile(path, HEAD) as file:
        assert file.records == RECORDS and math.copysign(1, file.records[2][1][2]) == -1
        assert math.isnan(file.add(math.nan))
    with RecordFile(path, HEAD) as file:
        assert len(file.records) == 4
        file.remove()
    assert not path.exists()


def test_cut_anywhere_the_records_before_come_back_and_the_file_grows_from_there(tmp_path):
    path = filled(tmp_path / "x")
    data = path.read_bytes()
    ends = [i + 1 for i, byte in enumerate(data) if byte == ord("\n")]
    for size in range(len(data) + 1):
        path.write_bytes(data[:size])
        with RecordFile(path, HEAD) as file:
            whole = max(0, sum(end <= size for end in ends) - 1)
            assert file.records == RECORDS[:whole]
            file.add("more")
        with RecordFile(path, HEAD) as file:
            assert file.records == [*RECORDS[:whole], "more"]


@settings(max_examples=60, deadline=None, database=None, derandomize=True)
@given(at=st.integers(0, 10**6), bit=st.integers(0, 7))
def test_a_flipped_bit_never_gives_a_record_that_was_not_there(tmp_path_factory, at, bit):
    path = filled(tmp_path_factory.mktemp("flip") / "x")
    data = bytearray(path.read_bytes())
    data[at % len(data)] ^= 1 << bit
    path.write_bytes(data)
    try:
        with RecordFile(path, HEAD) as file:
            assert file.records == RECORDS[: len(file.records)]
    except HnavError as error:
        assert "is something else; remove it" in str(error) and path.read_bytes() == data


def test_records_of_something_else_are_refused_by_what_differs(tmp_path):
    path = filled(tmp_path / "x")
    data = path.read_bytes()
    for head, said in (
        (
            {"kind": "numbers", "step": 0.2},
            "was begun with step = 0.1, now it is 0.2: give the same, name another file, or remove it",
        ),
        ({"kind": "numbers"}, "was begun with step = 0.1, now it is not given"),
        (HEAD | {"more": 1}, "was begun with more = not given, now it is 1"),
    ):
        with pytest.raises(HnavError) as raised:
            RecordFile(path, head)
        assert said in str(raised.value) and path.read_bytes() == data
    other = tmp_path / "letter"
    other.write_text("Dear all,\n")
    with pytest.raises(HnavError, match="letter: is something else; remove it, or name another file"):
        RecordFile(other, HEAD)
    assert other.read_text() == "Dear all,\n"


def test_a_file_without_records_accepts_another_head(tmp_path):
    with RecordFile(tmp_path / "x", HEAD):
        killed = (tmp_path / "x").read_bytes()
    assert not (tmp_path / "x").exists()
    (tmp_path / "x").write_bytes(killed)
    with RecordFile(tmp_path / "x", {"kind": "letters"}) as file:
        assert file.records == []


def test_two_processes_do_not_mix_their_records(tmp_path):
    with RecordFile(tmp_path / "x", HEAD) as file:
        with pytest.raises(HnavError, match="another process is adding to it"):
            RecordFile(tmp_path / "x", HEAD)
        file.add(1)


def test_a_full_disk_takes_no_half_record(tmp_path):
    path = filled(tmp_path / "x")
    with RecordFile(path, HEAD) as file:
        with no_longer_than(path.stat().st_size + 20), pytest.raises(OutputError, match="cannot write .*/x: file too large"):
            file.add("a" * 1000)
        assert file.records == RECORDS
        file.add("small")
    with RecordFile(path, HEAD) as file:
        assert file.records == [*RECORDS, "small"]
    with pytest.raises(OutputError, match="cannot write"):
        RecordFile(path / "below", HEAD)


def test_a_killed_process_keeps_what_it_had_added(tmp_path):
    child = os.fork()
    if child == 0:
        file = RecordFile(tmp_path / "x", HEAD)
        file.add(1)
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(child, 0)
    with RecordFile(tmp_path / "x", HEAD) as file:
        assert file.records == [1]
