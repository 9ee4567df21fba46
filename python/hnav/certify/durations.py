"""Durations against a limit, with a tolerance for the rounding of time stamps, as in c_src/base/instant.hpp."""

TIE_SHARE = 1e-4
GAP_INTERVALS = 3 + 1e-3
"""Usual intervals after which samples are missing: two lost samples are the limit itself (c_src/signals/sampling.hpp)."""


def has_lasted(length_s: float, limit_s: float) -> bool:
    return bool(length_s >= (1 - TIE_SHARE) * limit_s)


def has_passed(length_s: float, limit_s: float) -> bool:
    return bool(length_s > (1 + TIE_SHARE) * limit_s)


def is_within(length_s: float, limit_s: float) -> bool:
    """For NaN, no time at all, both this and has_lasted are false."""
    return bool(length_s < (1 - TIE_SHARE) * limit_s)


def is_gap(since_s: float, usual_s: float) -> bool:
    """Whether samples are missing, by the time since the last one and the usual time between two (0: not known)."""
    return usual_s > 0 and since_s > GAP_INTERVALS * usual_s


def usual_interval(since_s: float, usual_s: float) -> float:
    """The usual time between two samples, updated by the interval since_s (NaN: first sample)."""
    if not since_s > 0:
        return usual_s
    if not usual_s > 0:
        return since_s
    return 1.2 * usual_s if is_gap(since_s, usual_s) else usual_s + 0.1 * (since_s - usual_s)
