"""The size of the residuals against a known sigma and against whole pixels."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import chdtr, chdtrc

from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem
from bayescal.noise.level import WHOLE_PIXEL

# At less than twice the floor rounding makes up a quarter of the variance.
NEAR = 2.0


def chi_squared(problem: Problem) -> AdequacyTest:
    """chi2 test against a known sigma, two-sided (Andrae et al. 2010, arXiv:1012.3754).

    The p-value is twice the smaller tail: a chi2 too small is as wrong as one too
    large.
    """
    name = "chi2, known sigma"
    sigma = problem.noise.plug_in
    if sigma is None:
        return untested(name, "sigma is not known but taken from the same residuals")
    if problem.noise.source == "replicates":
        return untested(
            name,
            "sigma is from the replicates, whose spread the residuals contain: lack of fit instead",
        )
    dof = problem.dof
    if dof <= 0:
        return untested(name, problem.unusable or "no residual is left")
    chi2 = problem.rss / sigma**2
    upper, lower = float(chdtrc(dof, chi2)), float(chdtr(dof, chi2))
    p = min(1.0, 2 * min(upper, lower))
    if p >= 0.05:
        says = "as it should be"
    elif upper < lower:
        says = "the order is too low, sigma too small or errors are not all noise"
    else:
        says = "sigma is stated too large, or residuals are not independent of the fit"
    return AdequacyTest(
        name,
        "chi2",
        chi2,
        (dof,),
        p,
        f"chi2/dof = {chi2 / dof:.3g}, expected 1 ± {math.sqrt(2 / dof):.2g}: {says}.",
    )


def whole_pixels(problem: Problem) -> AdequacyTest:
    """Notice readings that are all whole numbers, which puts a floor under sigma."""
    name = "whole-pixel readings"
    t, unit = problem.data.t, problem.unit
    if not (t == np.round(t)).all():
        return untested(name, "readings are not all whole numbers")
    if problem.data.sd is not None:
        inferred = problem.noise.value is None  # a factor on the deviations
        factor = (problem.sigma_hat if inferred else problem.noise.value) or 1.0
        sigma = float(np.median(problem.data.sd)) * factor
        whose = "the median sigma" if inferred else "the median known sigma"
    elif problem.noise.plug_in is not None:
        known = problem.noise.source == "known"
        sigma, whose = problem.noise.plug_in, "the known sigma" if known else "sigma of replicates"
    elif problem.sigma_hat is not None:
        sigma, whose = problem.sigma_hat, "sigma of the residuals"
    else:
        return untested(name, "readings are whole numbers, but no residual is left to compare")
    share = f"{100 * (WHOLE_PIXEL / sigma) ** 2:.0f}%" if sigma > WHOLE_PIXEL else "all"
    near = sigma < NEAR * WHOLE_PIXEL
    says = (
        f"rounding makes up {share} of the variance, so that errors are neither normal nor "
        "independent of the position within a pixel"
        if near
        else f"rounding makes up {share} of the variance and does not matter"
    )
    return AdequacyTest(
        name,
        "sigma / floor",
        sigma / WHOLE_PIXEL,
        None,
        None,
        f"All readings are whole numbers, which alone scatters them by 0.29 {unit}; {whose} is "
        f"{sigma:.3g} {unit}: {says}.",
        concern=near,
    )
