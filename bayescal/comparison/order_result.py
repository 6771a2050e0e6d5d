"""One order of one axis, judged."""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.comparison.criteria import Criteria
from bayescal.comparison.goodness import GoodnessOfFit
from bayescal.comparison.judged import Judged
from bayescal.inference.posterior import Posterior
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.least_squares import LeastSquaresFit


@dataclass(frozen=True, eq=False, kw_only=True)
class OrderResult(Judged):
    """One order on one axis: what a candidate is judged by, and its likelihood.

    Attributes
    ----------
    fit : LeastSquaresFit
        Least squares: of maximum likelihood where the noise is Gaussian.
    rss_px2 : float
        Residual sum of squares, px^2, unweighted.
    goodness : GoodnessOfFit
        Without numbers where the noise is not Gaussian, as are the criteria.
    criteria : Criteria
    posterior : Posterior
        Draws and their summaries, beside the closed form where there is one.
    """

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

    def __repr__(self) -> str:
        chance = "" if self.probability is None else f", probability {self.probability:.3f}"
        return f"<OrderResult: order {self.order}, RSS {self.rss_px2:.1f} px^2{chance}>"
