"""Least squares of raw monomials in 80-digit arithmetic: a truth for doubles to meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mpmath import lu_solve, matrix, mp, mpf, workdps

DIGITS = 80


@dataclass
class ExactFit:
    """Coefficients (lowest power first), standard errors, residual sum of squares."""

    coefficients: list[mpf]
    standard_errors: list[mpf]
    rss: mpf


def exact_fit(x: Sequence[mpf], y: Sequence[mpf], order: int) -> ExactFit:
    """Fit by the normal equations of raw monomials.

    They square the condition number, 1e20 at the worst here, of which 80 digits
    leave 60. Call it, and form x and y, within ``workdps(DIGITS)``.
    """
    assert mp.dps == DIGITS
    size = order + 1
    powers = [[v**j for j in range(size)] for v in x]
    gram = matrix(size, size)
    moments = matrix(size, 1)
    for i in range(size):
        moments[i] = mp.fsum(row[i] * v for row, v in zip(powers, y, strict=True))
        for j in range(size):
            gram[i, j] = mp.fsum(row[i] * row[j] for row in powers)
    beta = list(lu_solve(gram, moments))
    residuals = [v - mp.fdot(row, beta) for row, v in zip(powers, y, strict=True)]
    rss = mp.fdot(residuals, residuals)
    inverse = gram**-1
    variance = rss / (len(x) - size)
    errors = [mp.sqrt(variance * inverse[j, j]) for j in range(size)]
    return ExactFit(beta, errors, rss)


def relative_error(found: float, truth: mpf) -> float:
    """|found / truth - 1|, or |found| where the truth is zero."""
    with workdps(DIGITS):
        scale = abs(truth) if truth else mpf(1)
        return float(abs(mpf(found) - truth) / scale)


def correct_digits(found: float, truth: str) -> float:
    """Minus log10 of the relative error (of the error where the truth is zero)."""
    with workdps(DIGITS):
        error = relative_error(found, mpf(truth))
        return float(-mp.log10(error)) if error else 17.0
