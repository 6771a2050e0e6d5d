"""One order of one axis, judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bayescal.comparison.criteria.goodness import GoodnessOfFit
from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.faces import convert
from bayescal.comparison.judged import Judged
from bayescal.inference.posterior import ParameterSummary, Posterior
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.polynomials.axis_data import AxisData


@dataclass(frozen=True, eq=False, kw_only=True)
class OrderResult(Judged, convert.Converts):
    """One order on one axis: what a candidate is judged by, and its likelihood.

    Attributes
    ----------
    data : AxisData
        What it is of.
    fit : LeastSquaresFit
        Least squares: of maximum likelihood where the noise is Gaussian.
    rss_px2 : float
        Residual sum of squares, px^2, unweighted.
    goodness : GoodnessOfFit
        Without numbers where the noise is not Gaussian, as are the criteria.
    posterior : Posterior
        Draws and their summaries, beside the closed form where there is one.
    """

    data: AxisData
    fit: LeastSquaresFit
    rss_px2: float
    goodness: GoodnessOfFit
    criteria: Criteria
    posterior: Posterior

    @property
    def order(self) -> int:
        """Which order it is."""
        return self.key.orders[0]

    @property
    def exact(self) -> ExactPosterior | None:
        """The closed form; None where the noise leaves none."""
        return self.posterior.exact

    @property
    def summaries(self) -> Sequence[ParameterSummary]:
        """Of the draws."""
        return self.posterior.parameters

    def held(self) -> convert.Held:
        """Give draws, densities and data."""
        return convert.order_held(self.posterior, self.data)

    def __repr__(self) -> str:
        chance = "" if self.probability is None else f", probability {self.probability:.3f}"
        return f"<OrderResult: order {self.order}, RSS {self.rss_px2:.1f} px^2{chance}>"
