"""Least trimmed squares: the fits that half of the points agree on, each another half."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array

TRIALS, STEPS = 200, 30
# Fits kept: those of the smallest scales that differ by more than their scale somewhere.
KEPT = 8
# Of more points than this a random sample is searched.
POINTS = 500
# Fits that differ by less than this share of the readings' span differ by rounding.
ROUNDING = 1e-9


def trimmed_fits(design: Array, t: Array) -> list[tuple[Array, float]]:
    """Local minima of least trimmed squares over half of the points, the tightest first.

    From subsets just large enough, fits are repeated on the half of the points that the last
    one meets best, which never raises their sum of squares (FAST-LTS: Rousseeuw & Van Driessen
    2006, Data Min. Knowl. Discov. 12, 29, theorem 1). Where bad points may be many, each
    minimum may be a mode of its own.

    Parameters
    ----------
    design : Array
        ``(n_points, n_coefficients)``.
    t : Array
        ``(n_points,)``, px.

    Returns
    -------
    list of tuple
        Amplitudes, and root mean square of the half's residuals, px; at most `KEPT`.
    """
    rng = np.random.default_rng(0)
    sample = rng.permutation(len(t))[:POINTS]
    x, y = design[sample], t[sample]
    n, p = x.shape
    if n <= p + 1:
        return []
    half = (n + p + 1) // 2
    found = []
    for _ in range(TRIALS):
        chosen = rng.choice(n, p + 1, replace=False)
        for _ in range(STEPS):
            amplitudes = np.linalg.lstsq(x[chosen], y[chosen], rcond=None)[0]
            distance = np.abs(y - x @ amplitudes)
            before, chosen = chosen, np.sort(np.argsort(distance, kind="stable")[:half])
            if np.array_equal(before, chosen):
                break
        found.append((amplitudes, float(np.sqrt(np.mean(distance[chosen] ** 2)))))
    found.sort(key=lambda fit: fit[1])
    kept: list[tuple[Array, float]] = []
    same = ROUNDING * float(np.ptp(y))
    for amplitudes, scale in found:
        far = max(scale, same)
        if all(np.abs(x @ (amplitudes - other)).max() > far for other, _ in kept):
            kept.append((amplitudes, scale))
        if len(kept) == KEPT:
            break
    return kept
