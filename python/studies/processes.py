"""Work shared out to processes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Found = TypeVar("Found")


def in_order(judge: Callable[[Item], Found], items: Iterable[Item], workers: int, chunk: int = 1) -> Iterator[Found]:
    """Results of judge for each item, in their order, for any number of workers; 1: in this process.

    chunk: items that a worker is given at once.
    """
    if workers == 1:
        yield from map(judge, items)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(judge, items, chunksize=chunk)
