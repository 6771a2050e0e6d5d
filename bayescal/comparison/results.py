"""The results of a comparison: small frozen values, each estimate with its error."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from bayescal.comparison.criteria.goodness import ReferenceSigma
from bayescal.comparison.faces.face import ByAxis, Lists, Recommends
from bayescal.comparison.faces.frames import orders_frame
from bayescal.comparison.findings.surroundings import another_model
from bayescal.comparison.orders.averaging import AveragedPrediction
from bayescal.comparison.orders.result import OrderResult as OrderResult
from bayescal.comparison.orders.verdict import AxisVerdict
from bayescal.markup import bullets, table
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from bayescal.rounding import percent, plain, significant

if TYPE_CHECKING:  # a plain comparison does not pay for the defence
    import pandas as pd

    from bayescal.comparison.adequacy.outcome import AdequacyTest
    from bayescal.comparison.defence.results import Defence
    from bayescal.comparison.defence.world_units import WorldUnit
    from bayescal.comparison.settings import Settings


@dataclass(frozen=True, eq=False)
class AxisComparison(Recommends, Lists[int, OrderResult]):
    """The orders of one axis, compared.

    Attributes
    ----------
    noise_source : str
        How the noise level was chosen, in words.
    reference : ReferenceSigma
        What chi-squared is measured in.
    scatter : tuple
        Spread of points that share this regressor, px (None where none do), and its
        degrees of freedom: noise plus what the regressor does not explain.
    orders : tuple of OrderResult
        Ascending.
    defence : Defence or None
        Answers to a referee, where they were asked for.
    adequacy : tuple of AdequacyTest
        Of the recommended order, where a defence was asked for.
    world_units : tuple of WorldUnit
        What one unit of error in the world is worth, where a defence was asked for and
        the world coordinates' errors are not stated.
    noise_model : NoiseModel
        Shape of the noise about its level.
    averaged : AveragedPrediction or None
        Prediction averaged over orders, beside the recommended one's.
    """

    data: AxisData
    noise: NoiseLevel
    noise_source: str
    prior: PriorRule
    reference: ReferenceSigma
    scatter: tuple[float | None, int]
    orders: tuple[OrderResult, ...]
    verdict: AxisVerdict
    defence: Defence | None = None
    adequacy: tuple[AdequacyTest, ...] = ()
    world_units: tuple[WorldUnit, ...] = ()
    noise_model: NoiseModel = GAUSSIAN
    averaged: AveragedPrediction | None = None

    absent = "order {0} was not compared; orders: {1}"

    def named(self) -> list[tuple[int, OrderResult]]:
        """List the orders."""
        return [(result.order, result) for result in self.orders]

    def to_dataframe(self) -> pd.DataFrame:
        """Orders in a data frame of pandas, a row each."""
        return orders_frame((self.data.axis, found) for found in self)

    @property
    def chosen(self) -> OrderResult:
        """The recommended order, or the one of lowest BIC where none can be."""
        order = self.verdict.order
        if order is not None:
            return self[order]
        return min(self.orders, key=lambda r: (r.criteria.bic is None, r.criteria.bic or 0.0))

    def __repr__(self) -> str:
        return f"<AxisComparison {self.data.axis}: {self.verdict.text}>"

    def _repr_html_(self) -> str:
        """Show orders and verdict in a notebook."""
        data, best = self.data, self.verdict.order
        unit = data.unit
        rows = [
            [
                f"{r.order} (recommended)" if r.order == best else f"{r.order}",
                plain(r.rss_px2),
                "" if r.fit.sigma_hat is None else significant(r.fit.sigma_hat, 3),
                _shown(r.criteria.aicc, ".1f"),
                _shown(r.criteria.bic, ".1f"),
                _shown(r.log_evidence, ".2f"),
                "" if r.probability is None else percent(r.probability),
            ]
            for r in self.orders
        ]
        heads = ["order", f"RSS, ({unit})²", f"sigma^, {unit}", "AICc", "BIC", "ln Z, nat"]
        caption = f"{data.axis} as a polynomial of {data.regressor}, {data.n} points"
        marked = next((i for i, r in enumerate(self.orders) if r.order == best), None)
        return table(caption, [*heads, "probability"], rows, marked=marked) + (
            self.verdict._repr_html_()
        )


@dataclass(frozen=True, eq=False)
class Comparison(ByAxis[AxisComparison]):
    """Everything that one analysis found.

    Attributes
    ----------
    axes : dict of str to AxisComparison
        ``"r"`` and ``"c"``, or ``"y"`` for a generic problem.
    points : Correspondences or None
        None for a generic problem.
    settings : Settings
        What was asked for: noise level, prior, seed and so on.
    notes : tuple of str
        What was assumed because nobody said otherwise.
    origin : dict or None
        The provenance of the run that holds exactly this comparison, where it was read from
        one; None where it was computed just now.
    derived : dict of str to Any
        What else took long, by name: a run keeps it.
    hint : str or None
        That another family of models or a free camera position is decisively better.
    """

    axes: dict[str, AxisComparison]
    family: str
    points: Correspondences | None
    settings: Settings
    notes: tuple[str, ...]
    origin: dict[str, Any] | None = None
    derived: dict[str, Any] = field(default_factory=dict, repr=False)
    hint: str | None = None

    def with_hint(self, hint: str | None) -> Comparison:
        """Give the comparison that knows whether another model is very strongly better."""
        if hint is None:
            return self
        found = [another_model(hint)]
        axes = {
            name: replace(axis, verdict=axis.verdict.with_findings(found))
            for name, axis in self.axes.items()
        }
        return replace(self, axes=axes, hint=hint)

    def to_dataframe(self) -> pd.DataFrame:
        """Orders of every axis in a data frame of pandas, a row each."""
        return orders_frame((axis.data.axis, found) for axis in self for found in axis)

    @property
    def seed(self) -> int:
        """Seed of the random numbers."""
        return self.settings.seed

    @property
    def sound(self) -> bool:
        """Whether every order's draws converged and agree with the closed form."""
        return all(result.sound for axis in self.axes.values() for result in axis.orders)

    @property
    def orders(self) -> dict[str, int | None]:
        """Recommended order of each axis."""
        return {name: axis.verdict.order for name, axis in self.axes.items()}

    def __repr__(self) -> str:
        lines = [f"  {name}: {axis.verdict.text}" for name, axis in self.axes.items()]
        return "\n".join([f"<Comparison: family {self.family}", *lines]) + ">"

    def _repr_html_(self) -> str:
        """Show every axis in a notebook, and what was assumed."""
        axes = "".join(axis._repr_html_() for axis in self.axes.values())
        return axes + bullets("Notes", self.notes)


def _shown(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)
