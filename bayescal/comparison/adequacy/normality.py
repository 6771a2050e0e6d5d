"""Whether the studentised residuals are normal."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem

NAME = "normality"
SHAPIRO_LIMIT = 5000  # points, above which W's p-value is not known (Royston 1995)
FEWEST_DOF = 3  # with one, studentised residuals are +-1 whatever the errors


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
    from scipy.stats import jarque_bera, shapiro  # half a second, for a defence alone

    if len(z) <= SHAPIRO_LIMIT:
        if np.ptp(z) <= 1e-9:
            return untested(NAME, "all studentised residuals are equal")
        name, dof, (value, p) = "W", None, shapiro(z)
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
        float(value),
        dof,
        min(float(p), 1.0),
        f"Skewness {skew:.2g}, excess kurtosis {excess:.2g}, largest residual "
        f"{abs(z[worst]):.1f} sd (point {label}): {says}.",
    )


def shape(z: Array) -> tuple[float, float]:
    """Skewness and excess kurtosis, by moments."""
    d = z - z.mean()
    variance = float(np.mean(d**2))
    return float(np.mean(d**3)) / variance**1.5, float(np.mean(d**4)) / variance**2 - 3
