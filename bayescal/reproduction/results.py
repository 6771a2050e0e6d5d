"""What the thesis's procedure gives: fits before and after elimination, and what to say."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bayescal.arrays import Array, IntArray
from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.outliers.rejection import PointTests, Rejection, RejectionRule
from bayescal.linear.design_fit import DesignFit
from bayescal.points.correspondences import Correspondences
from bayescal.reproduction.models import AS_CODED, AS_WRITTEN, ThesisModel


@dataclass(frozen=True, eq=False)
class ThesisFit:
    """One model of the thesis, fitted by least squares to all points or to some.

    Attributes
    ----------
    kept : IntArray
        The points fitted, from 0, ascending, ``(n_kept,)``.
    fit : DesignFit
        To those points; coefficients in the listing's monomials, px.
    residuals : Array
        Measured less predicted of *all* points, ``(n_points,)``, px.
    """

    model: ThesisModel
    kept: IntArray
    fit: DesignFit
    residuals: Array
    criteria: Criteria

    @property
    def squared_errors(self) -> Array:
        """What the thesis calls chi-squared error (eq. 48, 49), ``(n_points,)``, px^2."""
        return self.residuals**2

    @property
    def rss(self) -> float:
        """Sum of squares over the points fitted, px^2."""
        return self.fit.rss

    @property
    def rms(self) -> float:
        """Root of their mean square, sqrt(rss / n), px."""
        return self.fit.rms

    @property
    def bic(self) -> float | None:
        """From the full likelihood, sigma counted where inferred; None for an exact fit."""
        return self.criteria.bic

    def __repr__(self) -> str:
        m = self.model
        return (
            f"<ThesisFit: {m.axis} {m.variant}, order {m.order}, {len(self.kept)} points, "
            f"RSS {self.rss:.1f} px^2>"
        )


@dataclass(frozen=True, eq=False)
class OrderReproduction:
    """One order of one axis and variant, before and after elimination.

    Attributes
    ----------
    before : ThesisFit
        To all points.
    tests : PointTests or None
        Standardised residuals of all points before elimination; None where they
        mean nothing (an exact fit, no degree of freedom).
    after : ThesisFit
        To the points that this order's elimination kept.
    common : ThesisFit or None
        To the points that every order kept, where that was asked for and they
        determine the model.
    """

    order: int
    before: ThesisFit
    tests: PointTests | None
    rejection: Rejection
    after: ThesisFit
    common: ThesisFit | None


@dataclass(frozen=True, eq=False)
class AxisReproduction:
    """The orders of one axis in one variant.

    Attributes
    ----------
    orders : tuple of OrderReproduction
        Ascending.
    common_kept : IntArray
        The points that every order's elimination kept, from 0, ascending.
    """

    variant: str
    axis: str
    orders: tuple[OrderReproduction, ...]
    common_kept: IntArray

    def __getitem__(self, order: int) -> OrderReproduction:
        for result in self.orders:
            if result.order == order:
                return result
        fitted = ", ".join(str(r.order) for r in self.orders)
        raise KeyError(f"order {order} was not fitted; orders: {fitted}")

    @property
    def same_points(self) -> bool:
        """Whether every order kept the same points, so that they can be compared after."""
        return all(len(o.after.kept) == len(self.common_kept) for o in self.orders)

    @property
    def name(self) -> str:
        """The axis and, where the variants differ, which of them: ``"r as coded"``."""
        return f"{self.axis} {self.variant.replace('-', ' ')}" if self.axis == "r" else self.axis

    @property
    def best(self) -> OrderReproduction | None:
        """The order of lowest BIC on all points; None where one fits exactly."""
        return _lowest_bic([(o, o.before) for o in self.orders])

    @property
    def best_on_common(self) -> OrderReproduction | None:
        """The order of lowest BIC on the common points; None where that is unavailable."""
        return _lowest_bic([(o, o.common) for o in self.orders])

    def gain_beyond(self, order: int) -> tuple[float, float]:
        """Find what the orders beyond one take off its RSS, and what chance alone would.

        Returns
        -------
        gain : float
            1 - rss(highest) / rss(order).
        by_chance : float
            (p_highest - p) / (n - p): its mean if the order is right and the noise
            Gaussian, for the ratio is then Beta distributed with these halves of
            degrees of freedom.
        """
        low, high = self[order].before, self.orders[-1].before
        columns = high.fit.n_coefficients - low.fit.n_coefficients
        gain = 1 - high.rss / low.rss if low.rss > 0 else 0.0
        return gain, columns / low.fit.dof if low.fit.dof > 0 else math.nan


def _lowest_bic(
    fits: list[tuple[OrderReproduction, ThesisFit | None]],
) -> OrderReproduction | None:
    found = [(fit.bic, order) for order, fit in fits if fit is not None and fit.bic is not None]
    if len(found) < len(fits):
        return None
    return min(found, key=lambda pair: pair[0])[1]


@dataclass(frozen=True, eq=False)
class Reproduction:
    """Everything that the thesis's procedure gives.

    Attributes
    ----------
    common : bool
        Whether all orders were also fitted to the points that all of them kept.
    variants : dict of str to dict of str to AxisReproduction
        By ``"as-written"``, ``"as-coded"``, then by ``"r"``, ``"c"``.
    warnings : tuple of str
        Where a comparison between orders would mislead.
    """

    points: Correspondences
    rule: RejectionRule
    common: bool
    variants: dict[str, dict[str, AxisReproduction]]
    warnings: tuple[str, ...]

    def __getitem__(self, variant: str) -> dict[str, AxisReproduction]:
        return self.variants[variant]

    @property
    def models(self) -> tuple[AxisReproduction, ...]:
        """What differs: r as written, r as coded where it is another model, and c."""
        written, coded = self.variants[AS_WRITTEN], self.variants[AS_CODED]
        slipped = any(o.before.model.slipped for o in coded["r"].orders)
        return (written["r"], *((coded["r"],) if slipped else ()), written["c"])

    @property
    def orders(self) -> tuple[int, ...]:
        """The orders fitted, ascending."""
        return tuple(o.order for o in self.variants[AS_WRITTEN]["r"].orders)

    def __repr__(self) -> str:
        lines = [
            f"  {model.name}: RSS " + ", ".join(f"{o.before.rss:.1f}" for o in model.orders)
            for model in self.models
        ]
        return "\n".join([f"<Reproduction: {len(self.points)} points", *lines]) + ">"
