"""A finished simulation in memory, as made, written and read by hnav.systems.simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hnav.errors import HnavValueError


@dataclass(frozen=True)
class Run:
    """A finished simulation: columns by "component.variable" and the content of run.json."""

    t_s: np.ndarray
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    about: dict[str, Any]

    @property
    def components(self) -> list[str]:
        return list(self.about["components"])

    def has(self, component: str, *names: str) -> bool:
        return all(f"{component}.{name}" in self.columns for name in names)

    def vector(self, component: str, name: str, size: int) -> np.ndarray:
        """component.name[1] ... [size] side by side, n x size. Raises HnavError when one is missing."""
        return np.column_stack([self[f"{component}.{name}[{i}]"] for i in range(1, size + 1)])

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.columns:
            raise HnavValueError("option", f"the run of {self.about['system']} has no signal {name}")
        return self.columns[name]
