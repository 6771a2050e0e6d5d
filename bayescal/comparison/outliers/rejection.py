r"""Elimination of bad points by a chi-squared test, one at a time, with a refit each.

The thesis (sections 5 and 6.2) proposes to remove bad points by "the chi-squared
test" but states neither a sigma nor a level. Here both are stated. With h the
leverage of a point and e its residual, the statistic of a point is

- sigma known: (e / (sigma sqrt(1 - h)))^2, chi-squared with one degree of freedom;
- sigma inferred: the squared externally studentised residual, sigma taken from the
  fit without the point, F with (1, n - p - 1) degrees of freedom. This is the exact
  form that the chi-squared test takes when sigma comes from the same residuals
  (Cook & Weisberg 1982, *Residuals and Influence in Regression*, 2.2.2).

The point of the largest statistic goes if it is significant, and what is left is
fitted again. At each step one of the n points left is bound to be the largest, so
the level is divided by n (Bonferroni) unless it is asked for per point: at 5 % per
point one point in twenty is removed from perfect data, and then from what is left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri, stdtr, stdtrit

from bayescal.arrays import Array, IntArray, frozen
from bayescal.errors import InputError
from bayescal.linear.design_fit import FULL_LEVERAGE, DesignFit, fit_design


@dataclass(frozen=True)
class RejectionRule:
    """When a point is taken for bad.

    Attributes
    ----------
    significance : float
        Probability of removing anything from data without a bad point (family-wise),
        or of calling any one good point bad (per point).
    per_point : bool
        Whether the significance is that of one point.
    sigma : float or None
        Known noise level, px; None: inferred from the residuals.
    """

    significance: float = 0.05
    per_point: bool = False
    sigma: float | None = None

    def __post_init__(self) -> None:
        if not 0 < self.significance < 1:
            raise InputError(
                f"significance must lie between 0 and 1, such as 0.05, not {self.significance:g}"
            )
        if self.sigma is not None and not (math.isfinite(self.sigma) and self.sigma > 0):
            raise InputError(f"sigma must be a positive number of px, not {self.sigma:g}")

    def level(self, n: int) -> float:
        """Level of the test of one of n points."""
        return self.significance if self.per_point else self.significance / n


@dataclass(frozen=True, eq=False)
class PointTests:
    """Every point of a fit measured in standard deviations of its own residual.

    Attributes
    ----------
    standardised : Array
        e / (s sqrt(1 - h)) with s the known sigma or that of the fit without the
        point, ``(n_points,)``; NaN for a point of full leverage, which alone fixes a
        coefficient and has no residual to test.
    p_values : Array
        Two-sided, ``(n_points,)``: chi-squared(1) or F(1, dof) of the square.
    dof : int or None
        n - p - 1; None where sigma is known.
    """

    standardised: Array
    p_values: Array
    dof: int | None

    def threshold(self, level: float) -> float:
        """Size of the standardised residual beyond which its p-value is below `level`."""
        if self.dof is None:
            return float(-ndtri(level / 2))
        return float(-stdtrit(self.dof, level / 2))


def point_tests(fit: DesignFit, sigma: float | None) -> PointTests | None:
    """Standardise the residuals of a fit.

    Parameters
    ----------
    sigma : float or None
        Known noise level, px; None: inferred from the other points' residuals.

    Returns
    -------
    PointTests or None
        None where no residual means anything: the fit is exact, or it has no degree
        of freedom left (with sigma inferred, one left over beside the point's own).
    """
    dof = fit.dof - 1
    if fit.exact or fit.dof < 1 or (sigma is None and dof < 1):
        return None
    spare = 1 - fit.leverages
    usable = fit.leverages < FULL_LEVERAGE
    own = np.divide(fit.residuals**2, spare, out=np.full(len(fit), np.nan), where=usable)
    if sigma is not None:
        size = np.sqrt(own) / sigma
        p_values = 2 * ndtr(-size)
    else:
        # The sum of squares without the point is rss - e^2 / (1 - h).
        without = np.maximum(fit.rss - own, 0.0) / dof
        with np.errstate(divide="ignore", invalid="ignore"):
            size = np.where(own == 0, 0.0, np.sqrt(own / without))
        p_values = 2 * stdtr(dof, -size)
    signed = np.copysign(size, fit.residuals)
    return PointTests(frozen(signed), frozen(p_values), None if sigma is not None else dof)


@dataclass(frozen=True)
class RejectionStep:
    """One point removed.

    Attributes
    ----------
    point : int
        Which, from 0, among all points.
    residual : float
        Its residual in the fit it was removed from, px.
    statistic : float
        Square of its standardised residual.
    p_value : float
        Of that one test.
    level : float
        What the p-value was compared with.
    n_points : int
        Points in the fit, this one included.
    """

    point: int
    residual: float
    statistic: float
    p_value: float
    level: float
    n_points: int


@dataclass(frozen=True, eq=False)
class Rejection:
    """What an elimination removed, and the fits before and after.

    Attributes
    ----------
    steps : tuple of RejectionStep
        In the order of going.
    kept : IntArray
        Points left, from 0, ascending, ``(n_kept,)``.
    before, after : DesignFit
        To all points, and to those left.
    stopped : str
        Why: ``"none significant"``, ``"too few points"`` or ``"exact fit"``.
    """

    rule: RejectionRule
    steps: tuple[RejectionStep, ...]
    kept: IntArray
    before: DesignFit
    after: DesignFit
    stopped: str

    @property
    def removed(self) -> tuple[int, ...]:
        """Points removed, from 0, in the order of going."""
        return tuple(step.point for step in self.steps)


def reject(design: Array, t: Array, rule: RejectionRule | None = None) -> Rejection:
    """Remove the most significant point and fit again, until none is significant.

    Known deviations per point are used by dividing rows of the design and pixels by
    them, with ``sigma=1``.

    Parameters
    ----------
    design : Array
        ``(n_points, n_coefficients)``.
    t : Array
        Measured pixels, ``(n_points,)``, px.
    rule : RejectionRule, optional
        5 % family-wise with sigma inferred by default.

    Raises
    ------
    InputError
        As `fit_design`.
    """
    design, t = np.asarray(design, dtype=float), np.asarray(t, dtype=float)
    rule = rule if rule is not None else RejectionRule()
    before = fit = fit_design(design, t)
    kept = np.arange(len(before))
    steps: list[RejectionStep] = []
    while True:
        tests = point_tests(fit, rule.sigma)
        if tests is None:
            stopped = "exact fit" if fit.exact else "too few points"
            break
        worst = int(np.nanargmax(np.abs(tests.standardised)))
        level = rule.level(len(fit))
        p_value = float(tests.p_values[worst])
        if p_value > level:
            stopped = "none significant"
            break
        size = float(tests.standardised[worst])
        steps.append(
            RejectionStep(
                int(kept[worst]), float(fit.residuals[worst]), size**2, p_value, level, len(fit)
            )
        )
        kept = np.delete(kept, worst)
        fit = fit_design(design[kept], t[kept])
    kept.setflags(write=False)
    return Rejection(rule, tuple(steps), kept, before, fit, stopped)
