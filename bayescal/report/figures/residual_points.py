"""What the pictures of residuals share: the residuals themselves, and whom to name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.report.figures.labels import printable_names

STANDS_OUT = 2.5  # studentised residuals beyond it are named,
NAMED = 8  # so many at most


@dataclass(frozen=True, eq=False)
class ResidualPoints:
    """Residuals of one order at its maximum-likelihood coefficients.

    Attributes
    ----------
    residuals : Array
        Measured less predicted, ``(n_points,)``, px.
    named : tuple of int
        Points that stand out, from 0, the worst first.
    names : tuple of str
        Of all points, printable.
    """

    problem: Problem
    residuals: Array
    named: tuple[int, ...]
    names: tuple[str, ...]

    @classmethod
    def of(cls, axis: AxisComparison, result: OrderResult) -> ResidualPoints:
        """Collect the residuals of an order."""
        problem = Problem.of(axis.data, result.fit, axis.noise)
        named: tuple[int, ...] = ()
        if problem.unusable is None:
            size = np.abs(problem.studentised)
            worst = [i for i in np.argsort(-size, kind="stable").tolist() if size[i] > STANDS_OUT]
            named = tuple(int(problem.usable[i]) for i in worst[:NAMED])
        return cls(problem, problem.e * problem.sd, named, printable_names(axis.data.labels))

    @property
    def sigma(self) -> float | None:
        """Noise level to compare with, px: known, else estimated; None where points differ."""
        if self.problem.data.sd is not None:
            return None
        known = self.problem.noise.value
        return known if known is not None else self.problem.sigma_hat

    @property
    def level(self) -> str:
        """How that level is known."""
        return "known" if self.problem.noise.value is not None else "estimated"

    def outstanding(self, unit: str) -> str:
        """Say which points stand out, with their residuals."""
        if not self.named:
            return f"No studentised residual is beyond {STANDS_OUT}."
        parts = [f"{self.names[i]} ({self.residuals[i]:+.3g} {unit})" for i in self.named]
        return f"Studentised residuals beyond {STANDS_OUT}: points {', '.join(parts)}."
