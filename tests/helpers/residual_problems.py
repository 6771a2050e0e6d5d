"""Problems of the adequacy tests, from points alone."""

from __future__ import annotations

from bayescal.comparison.adequacy.problem import Problem
from bayescal.linear.least_squares import factorise, solve
from bayescal.noise.level import NoiseLevel
from tests.helpers.problems import make_axis


def problem(x, t, order, sd=None, sigma=None) -> Problem:
    data = make_axis(x, t, sd=sd)
    noise = NoiseLevel.inferred() if sigma is None else NoiseLevel.known(sigma)
    return Problem.of(data, solve(factorise(data, order), order), noise)
