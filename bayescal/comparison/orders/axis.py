"""One axis, with all that its candidates share: data, noise level, prior, one factorisation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.choosing import check_resolved, noise_level, prior_rule
from bayescal.comparison.settings import Settings
from bayescal.linear.least_squares import Factorisation, LeastSquaresFit, factorise, solve
from bayescal.linear.model import LinearModel
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.points.setup import StatedPrior
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import CoefficientPrior, PriorRule


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a linear family.

    Attributes
    ----------
    data : AxisData
        With deviations only where they are used.
    source : str
        How the noise level was chosen, in words.
    highest : int
        The highest order compared, at which the points are factorised.
    shape : NoiseModel
        Of the noise about its level.
    """

    data: AxisData
    noise: NoiseLevel
    source: str
    rule: PriorRule
    family: str
    highest: int
    shape: NoiseModel = GAUSSIAN

    @classmethod
    def of(
        cls,
        data: AxisData,
        settings: Settings,
        *,
        family: str,
        highest: int,
        other: Array | None = None,
        stated: StatedPrior | None = None,
    ) -> Axis:
        """Choose noise level and prior; `other` is the other axis's regressor, ``(n_points,)``.

        Raises
        ------
        InputError
            Where the points can't determine the highest order, or have no such noise level.
        """
        data.check(highest)
        chosen = noise_level(data, settings, other, highest)
        rule = prior_rule(chosen.data, settings, stated)
        return cls(chosen.data, chosen.level, chosen.words, rule, family, highest, chosen.shape)

    def up_to(self, highest: int) -> Axis:
        """Give the same axis, for orders up to another one."""
        return self if highest == self.highest else replace(self, highest=highest)

    @cached_property
    def factors(self) -> Factorisation:
        """One factorisation for all orders."""
        return factorise(self.data, self.highest)

    def prior(self, order: int) -> CoefficientPrior:
        """Prior of an order's amplitudes."""
        return self.rule.of_degrees(self.data.degrees(order))

    def linear(self, order: int) -> LinearModel:
        """Make the model of an order under Gaussian noise."""
        return LinearModel(self.factors, order, self.noise, self.prior(order), self.data.symbol)

    def fit(self, order: int) -> LeastSquaresFit:
        """Least squares of an order."""
        return solve(self.factors, order, self.noise.plug_in)

    def rss_px2(self, fit: LeastSquaresFit) -> float:
        """Residual sum of squares, px^2, unweighted."""
        if self.data.sd is None:
            return fit.rss
        if self.data.whole is not None:
            return self.data.whole.plain.rss(fit.amplitudes)
        return float(np.sum(residuals(self.data, fit) ** 2))

    def check_resolved(self) -> None:
        """Refuse deviations so far below the residuals that rounding hides the likelihood."""
        where, rss = f"{self.data.source}: axis {self.data.axis}", self.fit(self.highest).rss
        check_resolved(where, self.noise, rss, self.data.n, self.highest)


def residuals(data: AxisData, fit: LeastSquaresFit) -> Array:
    """Measured less predicted at the maximum-likelihood coefficients, ``(n_points,)``, px."""
    return data.t - data.design(fit.order) @ fit.amplitudes
