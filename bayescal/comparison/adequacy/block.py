"""All adequacy tests of one order on one axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.adequacy.coordinate import other_coordinate, other_coordinate_within
from bayescal.comparison.adequacy.groups import shared_errors
from bayescal.comparison.adequacy.heteroscedasticity import heteroscedasticity
from bayescal.comparison.adequacy.level import chi_squared, whole_pixels
from bayescal.comparison.adequacy.normality import normality
from bayescal.comparison.adequacy.null import simulated_residuals
from bayescal.comparison.adequacy.outcome import AdequacyTest, adjusted
from bayescal.comparison.adequacy.predictive import posterior_predictive
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.adequacy.replicates import lack_of_fit, lack_of_fit_scatter
from bayescal.comparison.adequacy.sequence import runs_test
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData


def adequacy(
    data: AxisData,
    fit: LeastSquaresFit,
    noise: NoiseLevel,
    other: Array | None = None,
    depth: Array | None = None,
    groups: Sequence[str] | None = None,
    draws: Array | None = None,
    rng: np.random.Generator | None = None,
) -> tuple[AdequacyTest, ...]:
    """Test whether a fitted order is adequate for its points.

    The p-values hold for independent normal errors and an order chosen beforehand;
    an order that was chosen because it fits best looks a little better than it is.

    Parameters
    ----------
    fit : LeastSquaresFit
        Of the order to test, on the same points (and deviations).
    other : Array, optional
        The other axis's regressor (y/z for r), ``(n_points,)``.
    depth : Array, optional
        z in the camera's frame, ``(n_points,)``, world units.
    groups : tuple of str, optional
        Group of each point; by default points that share z.
    draws : Array, optional
        Posterior draws, ``(n_draws, m)``: monomial coefficients, then sigma where it is
        inferred, px; further columns are ignored.
    rng : numpy.random.Generator, optional
        For simulated p-values; seed 0 by default.

    Returns
    -------
    tuple of AdequacyTest
        p-values adjusted for each other (Holm); concerns are marked.
    """
    rng = rng if rng is not None else np.random.default_rng(0)
    problem = Problem.of(data, fit, noise)
    null = None if problem.unusable else simulated_residuals(problem.q, rng)
    tests = [
        chi_squared(problem),
        lack_of_fit(problem, other),
        lack_of_fit_scatter(problem, other),
        other_coordinate(problem, other),
        other_coordinate_within(problem, other),
        runs_test(problem, rng),
        heteroscedasticity(problem, depth, null),
        normality(problem),
        shared_errors(problem, groups, depth),
        *posterior_predictive(problem, draws, rng),
        whole_pixels(problem),
    ]
    return adjusted(test for test in tests if test is not None)
