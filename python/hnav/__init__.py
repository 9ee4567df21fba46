"""Hybrid navigation filters: the C library by ctypes, the same filters as FMUs by fmpy, and what goes around them.

library     the C API: options, filters, arrays in and out
fmus        the FMUs, driven by fmpy
engines     one call for both
recordings  files of real sensors
scores      errors against a reference attitude
reference   the filter again in NumPy, slow and readable: the oracle of the tests
ins_error_filter     linear models with time-correlated INS errors: MDKF, AMDKF and better
reference_ins_error  the same in NumPy
ins_error_table      Monte Carlo comparison of its forms
systems     systems of FMUs by SSP, checked
master      steps them
simulation  runs them and keeps what they put out; read_run
report      one page about a run; report_panels has its panels, run_views what they draw
montecarlo  many runs of a system
aircraft    linear aircraft from files, flown with INS errors and faults
"""

from hnav.errors import HnavError
from hnav.native.library import Filter, Options

__all__ = ["Filter", "HnavError", "Options", "__version__"]
__version__ = "0.1.0"
