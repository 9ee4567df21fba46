"""The stability certificate of a run of the HREKF: recorded gains, a semidefinite program, and figures that were checked."""
