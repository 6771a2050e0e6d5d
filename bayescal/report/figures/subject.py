"""What a figure is drawn of."""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.errors import InputError
from bayescal.inference.closed_form import ExactPosterior
from bayescal.inference.posterior import Posterior


@dataclass(frozen=True, eq=False)
class Subject:
    """A comparison, an axis of it, an order of that axis.

    Attributes
    ----------
    comparison : Comparison
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
        return posterior.exact if isinstance(posterior, Posterior) else None

    @property
    def unit(self) -> str:
        """Unit of what is measured: a generic y has its own."""
        return "unit of y" if self.axis.data.axis == "y" else "px"

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
