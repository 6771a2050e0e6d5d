"""Goodness of fit: chi-squared against a stated sigma, and F tests."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtr, chdtrc, fdtrc

from bayescal.arrays import Array
from bayescal.inference.least_squares import LeastSquaresFit
from bayescal.models.basis import SAME_REGRESSOR
from bayescal.models.linear import AxisData
from bayescal.models.noise import NoiseLevel


@dataclass(frozen=True)
class ReferenceSigma:
    """The sigma that chi-squared is measured in.

    Attributes
    ----------
    source : str
        ``"known"`` or ``"highest-order"``.
    value : float or None
        px; None where the highest order leaves no residual to take it from.
    dof : int or None
        Degrees of freedom of its estimate; None where sigma is known.
    """

    source: str
    value: float | None
    dof: int | None


def reference_sigma(noise: NoiseLevel, highest: LeastSquaresFit) -> ReferenceSigma:
    """Sigma for chi-squared: known, else the unbiased one of the highest order.

    With sigma fitted from the same residuals reduced chi-squared is 1 by
    construction, so the fitted one can't serve.
    """
    if noise.value is not None:
        return ReferenceSigma("known", noise.value, None)
    usable = highest.sigma_hat is not None and not highest.exact
    return ReferenceSigma("highest-order", highest.sigma_hat if usable else None, highest.dof)


@dataclass(frozen=True)
class GoodnessOfFit:
    """Chi-squared of one order at its maximum-likelihood coefficients.

    Attributes
    ----------
    chi2 : float or None
        Sum of squared standardised residuals.
    dof : int
        n - p.
    chi2_reduced : float or None
        chi2 / dof.
    chi2_reduced_sd : float or None
        sqrt(2 / dof), its sd where the model is right (Andrae et al. 2010).
    p_value, p_value_lower : float or None
        Upper and lower tail of chi2; only where sigma is known.
    f_p_value : float or None
        F test of the dropped orders against the highest one; only where sigma is
        not known.
    """

    chi2: float | None
    dof: int
    chi2_reduced: float | None
    chi2_reduced_sd: float | None
    p_value: float | None
    p_value_lower: float | None
    f_p_value: float | None


def goodness_of_fit(
    fit: LeastSquaresFit, highest: LeastSquaresFit, reference: ReferenceSigma
) -> GoodnessOfFit:
    """Judge one order against the reference sigma.

    Parameters
    ----------
    fit, highest : LeastSquaresFit
        The order, and the highest order compared.
    reference : ReferenceSigma

    Returns
    -------
    GoodnessOfFit
    """
    dof = fit.dof
    chi2 = None if reference.value is None else fit.rss / reference.value**2
    p = p_lower = f_p = None
    if reference.source == "known" and chi2 is not None and dof > 0:
        p, p_lower = float(chdtrc(dof, chi2)), float(chdtr(dof, chi2))
    if reference.source == "highest-order" and reference.value and fit.order < highest.order:
        dropped = highest.order - fit.order
        f = (fit.rss - highest.rss) / dropped / reference.value**2
        f_p = float(fdtrc(dropped, highest.dof, max(f, 0.0)))
    return GoodnessOfFit(
        chi2,
        dof,
        chi2 / dof if chi2 is not None and dof > 0 else None,
        math.sqrt(2 / dof) if dof > 0 else None,
        p,
        p_lower,
        f_p,
    )


@dataclass(frozen=True)
class Scatter:
    """Spread of the pixels among points that share the axis's regressor.

    It is pure error plus the dependence on everything else that differs, so it
    bounds the noise from above.

    Attributes
    ----------
    sigma : float or None
        px; None where no two points share a regressor.
    dof : int
    """

    sigma: float | None
    dof: int


def scatter(data: AxisData) -> Scatter:
    """Pooled spread within groups of equal regressor (to 1e-9 of the domain)."""
    order = np.argsort(data.x, kind="stable")
    x, t = data.x[order], data.t[order]
    new = np.append(True, np.diff(x) > SAME_REGRESSOR * (x[-1] - x[0]))
    group = np.cumsum(new) - 1
    dof = len(x) - int(group[-1]) - 1
    if dof == 0:
        return Scatter(None, 0)
    weights: Array = np.ones(len(x))
    means = np.bincount(group, t * weights) / np.bincount(group, weights)
    rss = float(((t - means[group]) ** 2).sum())
    return Scatter(math.sqrt(rss / dof), dof)
