"""The FMUs, driven by fmpy, and one call that runs a recording by the library or by an FMU."""
