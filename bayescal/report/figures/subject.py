"""What a figure is drawn of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.errors import InputError
from bayescal.linear.closed_form import ExactPosterior
from bayescal.polynomials.basis import Domain, MonomialMap


@dataclass(frozen=True, eq=False)
class Subject:
    """A comparison, an axis of it, an order of that axis.

    Attributes
    ----------
    name : str or None
        Of the axis; None: all axes.
    order : int or None
        None: the chosen one.
    """

    comparison: Comparison
    name: str | None
    order: int | None = None

    @property
    def axes(self) -> tuple[AxisComparison, ...]:
        """The axes to draw."""
        if self.name is not None:
            return (self.comparison.axes[self.name],)
        return tuple(self.comparison.axes.values())

    @property
    def axis(self) -> AxisComparison:
        """The axis."""
        (axis,) = self.axes
        return axis

    @property
    def result(self) -> OrderResult:
        """The order's result."""
        return self.axis.chosen if self.order is None else self.axis[self.order]

    @property
    def exact(self) -> ExactPosterior | None:
        """Closed form of the order's posterior; None where it has none."""
        posterior = self.result.posterior
        return posterior.exact if posterior.exact is not None else None

    @property
    def amplitude_draws(self) -> Array:
        """Legendre amplitudes of every draw of the coefficients, ``(n_draws, p)``, px."""
        posterior, data = self.result.posterior, self.axis.data
        size = self.result.order + 1
        if posterior.exact is not None:  # they are what was sampled
            return posterior.chain.theta[..., :size].reshape(-1, size)
        columns = [posterior.names.index(f"{data.symbol}_{j}") for j in range(size)]
        coefficients = posterior.chain.draws[..., columns].reshape(-1, size)
        return amplitudes(coefficients, data.domain)

    @property
    def unit(self) -> str:
        """Unit of what is measured: a generic y has its own."""
        return "unit of y" if self.axis.data.generic else "px"

    @property
    def title(self) -> str:
        """What is drawn, for a panel of one order."""
        data = self.axis.data
        return f"{data.axis}({data.regressor}), order {self.result.order}"

    @property
    def group_words(self) -> str:
        """What makes a group, in words."""
        points = self.comparison.points
        source = "column group" if points is None else points.causes()[0]
        return f"points that share a {source.removeprefix('column ')}"

    def check_order(self) -> None:
        """Refuse an order that was not compared.

        Raises
        ------
        InputError
        """
        compared = [r.order for r in self.axis.orders]
        if self.order not in compared:
            raise InputError(
                f"order {self.order} of {self.axis.data.axis} was not compared; orders: "
                f"{', '.join(map(str, compared))}"
            )


def amplitudes(coefficients: Array, domain: Domain) -> Array:
    """Legendre amplitudes of draws of monomial coefficients.

    Parameters
    ----------
    coefficients : Array
        ``(n_draws, n_coefficients)``, px.

    Returns
    -------
    Array
        ``(n_draws, n_coefficients)``, px.
    """
    to_monomials = MonomialMap(domain, coefficients.shape[1] - 1).matrix
    return np.linalg.solve(to_monomials, coefficients.T).T
