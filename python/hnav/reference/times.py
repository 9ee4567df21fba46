"""Lengths of time against a limit: rounding of stamps decides no tie, here as in c_src/base/instant.hpp."""

TIE_SHARE = 1e-4


def has_lasted(length_s: float, limit_s: float) -> bool:
    return bool(length_s >= (1 - TIE_SHARE) * limit_s)


def has_passed(length_s: float, limit_s: float) -> bool:
    return bool(length_s > (1 + TIE_SHARE) * limit_s)


def is_within(length_s: float, limit_s: float) -> bool:
    """Not the contrary of has_lasted for NaN: no time at all is neither."""
    return bool(length_s < (1 - TIE_SHARE) * limit_s)
