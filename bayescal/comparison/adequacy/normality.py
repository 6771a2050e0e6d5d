"""Whether the studentised residuals are normal.

W and its p-value as Royston 1995 (Appl. Statist. 44, 547, algorithm AS R94), as scipy.stats.shapiro
has them: importing scipy.stats takes a third of a comparison's time.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import chdtrc, ndtr, ndtri

from bayescal.arrays import Array
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem

NAME = "normality"
SHAPIRO_LIMIT = 5000  # points, above which W's p-value is not known (Royston 1995)
FEWEST_DOF = 3  # with one, studentised residuals are ±1 whatever the errors
# Royston's polynomials, lowest powers first. Of n^-1/2: the two outermost weights.
_OUTERMOST = (0.0, 0.221157, -0.147981, -2.07119, 4.434685, -2.706056)
_NEXT = (0.0, 0.042981, -0.293762, -1.752461, 5.682633, -3.582633)
# Of n up to 11: what ln(1 - W) stays below, mean and ln sd of its transform.
_LARGEST = (-2.273, 0.459)
_FEW_MEAN = (0.544, -0.39978, 0.025054, -6.714e-4)
_FEW_LOG_SD = (1.3822, -0.77857, 0.062767, -0.0020322)
# Of ln n: mean and ln sd of ln(1 - W).
_MEAN = (-1.5861, -0.31082, -0.083751, 0.0038915)
_LOG_SD = (-0.4803, -0.082676, 0.0030302)


def normality(problem: Problem) -> AdequacyTest:
    """Shapiro-Wilk test on studentised residuals; Jarque-Bera above 5000 points.

    Fitting mixes errors and makes residuals look more normal than they are, so the
    test is conservative where coefficients are many for the points: on normal errors
    it rejects 5 % at 57 points and order 4, 3 % at 15, 1 to 2 % at 10.
    """
    if problem.unusable:
        return untested(NAME, problem.unusable)
    z = problem.studentised
    if problem.dof < FEWEST_DOF or len(z) < FEWEST_DOF:
        return untested(NAME, f"{problem.dof} degrees of freedom are too few")
    if len(z) <= SHAPIRO_LIMIT:
        if np.ptp(z) <= 1e-9:
            return untested(NAME, "all studentised residuals are equal")
        name, dof, (value, p) = "W", None, shapiro_wilk(z)
    else:
        name, dof, (value, p) = "JB", (2,), jarque_bera(z)
    worst = int(np.argmax(np.abs(z)))
    label = problem.data.labels[int(problem.usable[worst])]
    skew, excess = shape(z)
    says = (
        "Gaussian noise is tenable"
        if p >= 0.05
        else "outliers, or noise that is not Gaussian, as standard errors, evidence and intervals "
        "assume it to be"
    )
    return AdequacyTest(
        NAME,
        name,
        value,
        dof,
        p,
        f"Skewness {skew:.2g}, excess kurtosis {excess:.2g}, largest residual "
        f"{abs(z[worst]):.1f} sd (point {label}): {says}.",
    )


def shapiro_wilk(z: Array) -> tuple[float, float]:
    """W and its p-value, of 3 to 5000 values that are not all the same."""
    n, ordered = len(z), np.sort(z - np.median(z))
    upper = ndtri((np.arange(n, n - n // 2, -1) - 0.375) / (n + 0.25))  # scores, outermost first
    squares, root = 2 * float(upper @ upper), 1 / math.sqrt(n)
    if n == 3:
        weights = np.array([math.sqrt(0.5)])
    else:
        fixed = 2 if n > 5 else 1
        outer = np.array([_value(c, root) for c in (_OUTERMOST, _NEXT)[:fixed]])
        outer += upper[:fixed] / math.sqrt(squares)
        left = squares - 2 * float(upper[:fixed] @ upper[:fixed])
        weights = upper * math.sqrt((1 - 2 * float(outer @ outer)) / left)
        weights[:fixed] = outer
    differences = ordered[::-1][: n // 2] - ordered[: n // 2]
    d = ordered - ordered.mean()
    w = min(float(weights @ differences) ** 2 / float(d @ d), 1.0)
    return w, _p_value(w, n)


def _p_value(w: float, n: int) -> float:
    """Probability of a smaller W of n normal values."""
    if n == 3:
        return max(6 / math.pi * (math.asin(math.sqrt(w)) - math.asin(math.sqrt(0.75))), 0.0)
    if w == 1:
        return 1.0
    y = math.log(1 - w)
    if n <= 11:
        gap = _value(_LARGEST, n) - y
        if gap <= 0:
            return 0.0
        y, mean, log_sd = -math.log(gap), _value(_FEW_MEAN, n), _value(_FEW_LOG_SD, n)
    else:
        mean, log_sd = _value(_MEAN, math.log(n)), _value(_LOG_SD, math.log(n))
    return float(ndtr((mean - y) / math.exp(log_sd)))


def _value(coefficients: tuple[float, ...], x: float) -> float:
    return float(np.polynomial.polynomial.polyval(x, coefficients))


def jarque_bera(z: Array) -> tuple[float, float]:
    """JB and its p-value by the chi-squared distribution with two degrees of freedom."""
    skew, excess = shape(z)
    value = len(z) / 6 * (skew**2 + excess**2 / 4)
    return value, float(chdtrc(2, value))


def shape(z: Array) -> tuple[float, float]:
    """Skewness and excess kurtosis, by moments."""
    d = z - z.mean()
    variance = float(np.mean(d**2))
    return float(np.mean(d**3)) / variance**1.5, float(np.mean(d**4)) / variance**2 - 3
