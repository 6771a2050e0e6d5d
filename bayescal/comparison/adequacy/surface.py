"""Whether residuals follow a smooth surface over the image."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import fdtrc

from bayescal.arrays import Array
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem, scaled
from bayescal.polynomials.plane import plane_design
from bayescal.rounding import significant

NAME = "surface over the image"
# Degree of the surface: a tangential distortion, a skew and a radial one are of two and three.
DEGREE = 3
# Degrees of freedom to be left, below which a lower degree is taken.
SPARE = 5


def surface(problem: Problem, place: Array) -> AdequacyTest:
    """F test of a polynomial of both pixel coordinates, added to the design (Draper & Smith, 6.2).

    Parameters
    ----------
    place : Array
        Predicted pixels of each point, ``(2, n_points)``, px.
    """
    if problem.unusable:
        return untested(NAME, problem.unusable)
    across, down = (scaled(v) for v in place)
    for degree in range(DEGREE, 0, -1):
        added = problem.extend(plane_design(across, down, degree))
        if added.rank > 0 and added.dof >= SPARE:
            break
    else:
        return untested(NAME, "too few points for a surface beside the model")
    worth = math.sqrt(float(np.mean((added.shift * problem.sd) ** 2)))
    before, after = math.sqrt(problem.rss / problem.dof), math.sqrt(added.rss / added.dof)
    if added.exact:
        value, p, noise = None, 0.0, 0.0
    else:
        value, p = added.f, float(fdtrc(added.rank, added.dof, added.f))
        noise = after * math.sqrt(float(np.mean(added.leverage * problem.sd**2)))
    own = problem.unit if problem.data.sd is None else "deviations"
    sigmas = " to ".join(significant(s, 3) for s in (before, after))
    meaning = (
        f"A surface of degree {degree} takes up {significant(worth)} {problem.unit} rms (noise "
        f"alone would give {significant(noise)}), and sigma goes from {sigmas} {own}."
    )
    return AdequacyTest(NAME, "F", value, (added.rank, added.dof), p, meaning)
