"""Damage of every kind for files that readers are to refuse, or to read whole."""

from __future__ import annotations

import os
import random
from collections.abc import Iterator
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st

bounded = settings(max_examples=int(os.environ.get("HNAV_FUZZ_EXAMPLES", "30")), deadline=None, database=None, derandomize=True)
DEEP = "[" * 100_000

json_values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(10**400), 10**400), st.floats(), st.text(max_size=5)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=5), inner, max_size=3)),
    max_leaves=6,
)


def places(node: Any, path: tuple = ()) -> Iterator[tuple]:
    """The ways to all values of a JSON document."""
    yield path
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in items:
        yield from places(child, (*path, key))


def with_another_value(document: Any, data: st.DataObject) -> Any:
    """The document with any value in any of its places, or without the place."""
    ways = [way for way in places(document) if way]
    *branch, leaf = data.draw(st.sampled_from(ways))
    node = document
    for key in branch:
        node = node[key]
    if data.draw(st.booleans()):
        node[leaf] = data.draw(json_values)
    else:
        del node[leaf]
    return document


def damaged(data: bytes, seed: int) -> bytes:
    """A few bytes changed, a piece cut, doubled or moved."""
    rng = random.Random(seed)
    data = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        if not data:
            break
        i, j = sorted(rng.randrange(len(data) + 1) for _ in range(2))
        match rng.randrange(5):
            case 0:
                data[min(i, len(data) - 1)] = rng.randrange(256)
            case 1:
                del data[i:j]
            case 2:
                data[i:i] = data[i:j]
            case 3:
                del data[i:]
            case _:
                data[min(i, len(data) - 1)] ^= 1 << rng.randrange(8)
    return bytes(data)
