"""Goodness of fit: chi-squared against a stated sigma, and F tests."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.special import chdtr, chdtrc, fdtrc

from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.noise.level import NoiseLevel


@dataclass(frozen=True)
class ReferenceSigma:
    """The sigma that chi-squared is measured in.

    Attributes
    ----------
    source : str
        ``"known"``, ``"replicates"``, ``"highest-order"``, or ``"none"`` where the noise
        is not Gaussian and chi-squared has no meaning.
    value : float or None
        px (a factor where the points have deviations); None where there is no residual
        to take it from.
    dof : int or None
        Degrees of freedom of its estimate; None where sigma is known.
    """

    source: str
    value: float | None
    dof: int | None


NO_REFERENCE = ReferenceSigma("none", None, None)


def reference_sigma(
    noise: NoiseLevel, highest: LeastSquaresFit, replicates: tuple[float | None, int] = (None, 0)
) -> ReferenceSigma:
    """Sigma for chi-squared: known, else from replicates, else that of the highest order.

    With sigma fitted from the same residuals reduced chi-squared is 1 by
    construction, so the fitted one can't serve.

    Parameters
    ----------
    highest : LeastSquaresFit
        Of the highest order compared.
    replicates : tuple
        Pure error and its degrees of freedom.
    """
    if noise.source == "known":
        return ReferenceSigma("known", noise.value, None)
    pure, dof = replicates
    if pure:
        return ReferenceSigma("replicates", pure, dof)
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
        n - p; of r and c jointly 2n - p.
    chi2_reduced : float or None
        chi2 / dof.
    chi2_reduced_sd : float or None
        sqrt(2 / dof), its sd where the model is right (Andrae et al. 2010).
    p_value, p_value_lower : float or None
        Upper and lower tail of chi2; only where sigma is known.
    f_p_value : float or None
        Where sigma is not known: F test of lack of fit against replicates (Draper &
        Smith 1998, 2.1), or of the dropped orders against the highest one.
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
    """
    dof, f_p = fit.dof, None
    chi2 = None if reference.value is None else fit.rss / reference.value**2
    if reference.source == "replicates" and reference.value and reference.dof:
        lacking = dof - reference.dof
        if lacking > 0:
            pure = reference.dof * reference.value**2
            f = (fit.rss - pure) / lacking / reference.value**2
            f_p = float(fdtrc(lacking, reference.dof, max(f, 0.0)))
    if reference.source == "highest-order" and reference.value and fit.order < highest.order:
        dropped = highest.order - fit.order
        f = (fit.rss - highest.rss) / dropped / reference.value**2
        f_p = float(fdtrc(dropped, highest.dof, max(f, 0.0)))
    return chi_squared(chi2, dof, known=reference.source == "known", f_p_value=f_p)


def chi_squared(
    chi2: float | None, dof: int, *, known: bool, f_p_value: float | None = None
) -> GoodnessOfFit:
    """Judge a chi-squared, with its tails where sigma is `known`.

    Parameters
    ----------
    f_p_value : float, optional
        To go with it.
    """
    if chi2 is None or dof <= 0:
        spread = math.sqrt(2 / dof) if dof > 0 else None
        return GoodnessOfFit(chi2, dof, None, spread, None, None, f_p_value)
    upper, lower = (float(chdtrc(dof, chi2)), float(chdtr(dof, chi2))) if known else (None, None)
    return GoodnessOfFit(chi2, dof, chi2 / dof, math.sqrt(2 / dof), upper, lower, f_p_value)
