"""JSON, NumPy archives and MATLAB files of any names: tables in trees."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hnav.io.mat_file import read_mat
from hnav.io.readers.clock import DAMAGED
from hnav.io.readers.frames import raw_of_frames, sensor_stream
from hnav.io.readers.phones import joined_with_gravity, negates
from hnav.io.readers.stated_units import UNIT_NAMES, units_in
from hnav.io.readers.streams import CUT_OFF, Raw, Wishes, cannot_be_read
from hnav.io.readers.tables import lacks_gravity, table_of
from hnav.io.readers.trees import frames_of_tree, unbatched
from hnav.io.recordings import RecordingError

if TYPE_CHECKING:
    import pandas as pd

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
MATLAB_BLOCK = 512  # bytes
SENSOR_LOGGER = {"gyro": "rad/s", "accel": "m/s2", "mag": "uT"}
MOVESENSE = {"gyro": "deg/s", "accel": "m/s2", "mag": "uT", "time": "ms"}
"""API reference of Movesense, /Meas/Gyro: dps."""
MARKS = re.compile(r'"(?:[^"\\]|\\.)*(?:"|$)|[][{},]', re.DOTALL)
CLOSED_BY = {"[": "]", "{": "}"}


def is_json(path: Path, head: bytes) -> bool:
    begin = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    return begin[:1] == b"{" or (begin[:1] == b"[" and begin[1:].lstrip()[:1] in (b"{", b"[", b"]"))


def read_json(path: Path, wishes: Wishes) -> Raw:
    """Records, columns, Sensor Logger or Movesense. Raises RecordingError."""
    data = path.read_bytes()
    tree, torn = _parsed(path, data)
    frames = {name: unbatched(frame) for name, frame in frames_of_tree(tree).items()}
    try:
        raw = _of_frames(path, frames, tree, data, wishes)
    except RecordingError as error:
        if not torn:
            raise
        raise RecordingError(f"{error}; the file was cut off", error.argument) from None
    return replace(raw, notes=(*torn, *raw.notes))


def _of_frames(path: Path, frames: Mapping[str, pd.DataFrame], tree: Any, data: bytes, wishes: Wishes) -> Raw:
    if any(name.lower() == "gyroscope" for name in frames) and any("seconds_elapsed" in frame for frame in frames.values()):
        return _with_gravity(path, raw_of_frames(str(path), frames, wishes, "sensor-logger-json", SENSOR_LOGGER), frames, wishes)
    movesense = re.search(rb"ArrayGyro|ArrayAcc", data[:4096]) is not None
    return raw_of_frames(str(path), frames, wishes, "json", MOVESENSE if movesense else None, units_in(tree))


def _with_gravity(path: Path, raw: Raw, frames: Mapping[str, pd.DataFrame], wishes: Wishes) -> Raw:
    """The whole force of a phone that writes gravity apart."""
    by_name = {name.lower(): frame for name, frame in frames.items()}
    if "gravity" not in by_name or wishes.only_aids:
        return raw
    table = table_of(by_name["gravity"].rename(columns={axis: f"accel_{axis}" for axis in "xyz"}), str(path), wishes)
    gravity, *_ = sensor_stream(str(path), table, "accel", wishes, SENSOR_LOGGER)
    negated = any(map(negates, by_name["metadata"].to_dict("records"))) if "metadata" in by_name else False
    streams = [
        joined_with_gravity(one, gravity, negated) if one.sensor == "accel" and lacks_gravity(one.values, gravity.values) else one
        for one in raw.streams
    ]
    return replace(raw, streams=streams)


def _parsed(path: Path, data: bytes) -> tuple[Any, tuple[str, ...]]:
    """A tree, or a list of the trees of its lines; of a truncated file what is complete, and a note. Raises RecordingError."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise RecordingError(f"{path}: not a text file") from None
    try:
        return json.loads(text), ()
    except (ValueError, RecursionError) as error:
        fault = RecordingError(f"{path}: no JSON: {str(error).splitlines()[0]}")
    lines = [line.strip().rstrip(",") for line in text.splitlines() if line.strip() not in ("", "[", "]")]
    trees: list[Any] = []
    for line in lines:
        try:
            trees.append(json.loads(line))
        except (ValueError, RecursionError):
            break
    if len(trees) == len(lines):
        return trees, ()
    if trees and len(trees) == len(lines) - 1:
        return trees, (CUT_OFF,)
    try:
        return json.loads(whole_beginning(text)), (f"{DAMAGED}the file was cut off in its last entry, and what followed is lost",)
    except (ValueError, RecursionError):
        raise fault from None


def whole_beginning(text: str) -> str:
    """A JSON text that was cut off, closed, without what is not complete: the last of its records, else the last value of a mapping.
    Raises ValueError for another text."""
    opened: list[tuple[str, int]] = []
    """Brackets that are open, and where the last complete entry of each ends."""
    for mark in MARKS.finditer(text):
        sign = mark.group()
        if sign in CLOSED_BY:
            opened.append((sign, mark.end()))
        elif sign == "," and opened:
            opened[-1] = opened[-1][0], mark.start()
        elif sign in "}]":
            if not opened or CLOSED_BY[opened.pop()[0]] != sign:
                raise ValueError("brackets that do not match")
            if opened:
                opened[-1] = opened[-1][0], mark.end()
    if not opened:
        raise ValueError("no bracket is open")
    signs = "".join(sign for sign, _ in opened)
    between = signs[-1] == "[" and text[opened[-1][1] - 1] == "}"
    kept = len(signs) - 1 if between else max(signs.rfind("[{" if "[{" in signs else "{"), 0)
    return text[: opened[kept][1]] + "".join(CLOSED_BY[sign] for sign in reversed(signs[: kept + 1]))


def is_npz(path: Path, head: bytes) -> bool:
    return head.startswith(b"\x93NUMPY") or (head.startswith(b"PK\x03\x04") and b".npy" in head[:200])


def read_npz(path: Path, wishes: Wishes) -> Raw:
    """Arrays by name, or one array with named fields. Raises RecordingError."""
    try:
        with np.errstate(all="ignore"):
            loaded = np.load(path, allow_pickle=False)
            tree = dict(loaded) if hasattr(loaded, "files") else {"data": loaded}
    except Exception as error:  # NumPy raises errors of any type for a damaged file
        raise cannot_be_read(path, error) from None
    return _of_arrays(path, tree, wishes, "npz")


def is_hdf5(path: Path) -> bool:
    """Whether a file is HDF5; MATLAB 7.3 writes it behind a block of 512 bytes."""
    with path.open("rb") as file:
        head = file.read(MATLAB_BLOCK + len(HDF5_MAGIC))
    return HDF5_MAGIC in (head[: len(HDF5_MAGIC)], head[MATLAB_BLOCK:])


def read_mat_variables(path: Path, wishes: Wishes) -> Raw:
    """Variables of a MATLAB file, structs too. Raises RecordingError."""
    try:
        tree = _of_hdf5(path) if is_hdf5(path) else read_mat(path, ())
    except (ValueError, OSError, RuntimeError, KeyError) as error:
        raise RecordingError(f"{path}: cannot be read: {error}") from None
    return _of_arrays(path, tree, wishes, "mat")


def _of_hdf5(path: Path) -> dict[str, np.ndarray]:
    """Of MATLAB 7.3 and others: data sets by the names that lead to them."""
    import h5py

    found: dict[str, np.ndarray] = {}

    def take(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and not name.startswith("#"):
            key = name.replace("/", "_")
            found[key] = np.asarray(item[()])
            stated = next((value for called, value in item.attrs.items() if called.lower() in UNIT_NAMES), None)
            if stated is not None:
                found[f"{key}_unit"] = np.asarray(stated.decode() if isinstance(stated, bytes) else str(stated))

    with h5py.File(path) as file:
        file.visititems(take)
    return {name: np.atleast_1d(value.squeeze()) for name, value in found.items()}


def _of_arrays(path: Path, arrays: dict[str, np.ndarray], wishes: Wishes, format: str) -> Raw:
    tree: dict[str, Any] = {}
    for name, value in arrays.items():
        fields = {f"{name}_{field}": value[field] for field in value.dtype.names} if value.dtype.names else {name: value}
        tree |= {field: np.atleast_1d(one) for field, one in fields.items()}
    frames = frames_of_tree(tree)
    if not frames:
        there = ", ".join(f"{name} {' x '.join(map(str, value.shape))}" for name, value in list(tree.items())[:20]) or "nothing"
        raise RecordingError(
            f"{path}: no columns of numbers, but {there}: save t (n), gyro, acc, mag (n x 3 each), not a table object"
        )
    texts = {name: one.tolist() for name, one in tree.items() if one.dtype.kind in "SU"}
    return raw_of_frames(str(path), frames, wishes, format, units=units_in(texts))
