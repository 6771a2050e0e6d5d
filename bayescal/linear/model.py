"""One order of a linear family with its noise level and prior: a likelihood model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from bayescal.linear.evidence import Reduced
from bayescal.linear.least_squares import Factorisation
from bayescal.noise.level import NoiseLevel
from bayescal.prior.amplitudes import CoefficientPrior


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Gaussian likelihood of one order, reduced to O(p^2) numbers.

    Parameters, in this order: the Legendre amplitudes b_0 ... b_k (px), then
    ln sigma where sigma is inferred, then ln tau where tau is.

    Attributes
    ----------
    factors : Factorisation
        Of the axis, at this order or a higher one.
    prior : CoefficientPrior
        Of this order.
    symbol : str
        Name of the reported coefficients: ``"alpha"`` or ``"beta"``.
    """

    factors: Factorisation
    order: int
    noise: NoiseLevel
    prior: CoefficientPrior
    symbol: str = "alpha"

    @property
    def size(self) -> int:
        """Number of coefficients p."""
        return self.factors.monomials.columns(self.order)

    @property
    def infers_sigma(self) -> bool:
        """Whether ln sigma is a parameter."""
        return self.noise.value is None

    @property
    def infers_tau(self) -> bool:
        """Whether ln tau is a parameter."""
        return self.prior.infers_tau

    @property
    def dimension(self) -> int:
        """Number of sampled parameters."""
        return self.size + self.infers_sigma + self.infers_tau

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the reported parameters: coefficients, then sigma, then tau."""
        suffixes = self.factors.monomials.suffixes[: self.size]
        coefficients = tuple(f"{self.symbol}_{powers}" for powers in suffixes)
        return (
            coefficients + (self.noise.parameter,) * self.infers_sigma + ("tau",) * self.infers_tau
        )

    @cached_property
    def reduced(self) -> Reduced:
        """R, Q't and the residual sum of squares of this order."""
        return self.factors.reduced(self.order)
