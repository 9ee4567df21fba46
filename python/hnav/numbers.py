"""Numbers as callers hold them, as arrays of NumPy."""

import numpy as np
import numpy.typing as npt


def floats(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """float64, NaN where an array is masked. Raises TypeError or ValueError for values that are no numbers."""
    return np.asarray(np.ma.filled(np.ma.asarray(values, np.float64), np.nan))
