"""A certificate as rows of text: figure, value, meaning."""

from __future__ import annotations

import numpy as np

from hnav.certify.certificate import Certificate


def certificate_rows(found: Certificate) -> list[tuple[str, str, str]]:
    """(figure, value, meaning) for tables and reports, without the figures that were not reached."""

    def number(value: float, unit: str = "", digits: int = 3) -> str:
        return "-" if not np.isfinite(value) else f"{value:.{digits}g}{unit}"

    printed, starts = found.printed, found.starts
    assert printed is not None, "certify has measured it"
    free, whole = found.free_rate_1_s, "corrections" if found.longest_window == 1 else "windows"
    bound = number(found.gamma_squared) if np.isfinite(found.gamma_squared) else "infinite, gamma is off"
    limit = ""
    if np.isfinite(found.interval_limit_s):
        at = f"the {'correction' if found.longest_window == 1 else 'window that ends'} at {found.interval_limit_at_s:g} s"
        limit = f"; beyond {number(found.interval_limit_s)} s {at} alone lets errors grow"
    rows = [
        ("corrections", f"{found.corrections}", f"every {1e3 * found.interval_s:.4g} ms; library and reference agree to {found.largest_difference:.0e}"),
        ("windows", "-" if found.longest_window == 1 else f"{found.longest_window}", "corrections in the longest: a window ends when every sensor was seen, and it has to contract, no single correction"),
        ("unfinished", "-" if not found.unfinished else f"{found.unfinished}", "corrections at the end whose window did not end: the error is bounded there, no decay is claimed"),
        ("decay rate", number(found.rate_1_s, " 1/s"), f"one P for all {whole}; the slowest single one allows {number(found.spectral_rate_1_s)}"),
        ("region", number(found.region_deg, " deg"), f"largest attitude error inside; all below {number(found.sure_deg)} deg are, without bias error"),
        ("", number(found.region_bias_deg_s, " deg/s"), f"largest bias error inside; errors decay by {number(found.region_rate_1_s)} 1/s or more"),
        ("noise floor", number(found.noise_floor_deg, " deg"), f"bound on the rms error; {number(found.noise_share)} of the level, must stay below 1"),
        ("longest interval", number(found.longest_interval_s, " s"), f"{number(found.longest_interval_s / found.interval_s)} times the actual one: linear part, all corrections equally far apart, gains frozen (a filter run at that interval makes others: try --force-every and --field-every){limit}"),
        ("", number(found.mixed_interval_s, " s"), f"{number(found.mixed_interval_s / found.interval_s)} times: linear part, intervals from the actual one to this in any order; checked at both ends and four between"),
        ("", number(found.region_interval_s, " s"), f"{number(found.region_interval_s / found.interval_s)} times: with the nonlinear remainders, in a region of half the radius, no decay asked"),
        ("boundary starts", "-" if starts is None else f"{starts.worst_ratio:.6f}", "V over its bound at the worst correction of the nonlinear equations; must not exceed 1"),
        ("attenuation", number(found.attenuation), f"error energy over disturbance energy; gamma^2 = {bound}"),
        ("solver-free rate", number(float(free.min()), " 1/s"), f"by the filter's own covariance, at the slowest correction; median {number(float(np.median(free)))}"),
        ("theorem as printed", "holds" if printed.holds else "fails", f"d > 0 never; d < 0 needs a flow that contracts by {printed.needed_flow_rate_1_s:.3g} 1/s, it has {printed.flow_rate_1_s:.3g}"),
        ("search", f"{found.seconds:.1f} s" if found.solves else "-", f"{found.processor_s:.1f} s of processor time, {found.solves} programs over up to {found.vertices} corrections; least eigenvalue over all {number(found.smallest_eigenvalue)}"),
    ]  # fmt: skip
    return [row for row in rows if row[1] != "-"]
