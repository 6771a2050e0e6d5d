"""The answers to a referee that need every point, from a second pass over many points."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.criteria.leave_one_out import TotalLeaveOneOut
from bayescal.comparison.criteria.leaving import Leaving
from bayescal.comparison.defence.results import Defence, Prediction
from bayescal.comparison.defence.sensitivity import tau_sensitivity
from bayescal.comparison.defence.stability import RESAMPLES, Removal, bootstrap_of, removals
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.beyond import beyond
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.quadrature import FINE
from bayescal.linear.resampling import Resampling, without_each
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials import separable

# Points whose removal changes the winner that are listed.
LISTED = 100


def defend_many(
    axis: Axis,
    exact: Mapping[int, ExactPosterior],
    order: int | None,
    points: Iterable[Correspondences],
    rng: np.random.Generator,
) -> Defence:
    """Answer what a referee asks, reading the points again chunk by chunk.

    Groups, leave-one-out from the draws and other noise are left out.

    Parameters
    ----------
    axis : Axis
        Whose data are a sample of the points.
    exact : mapping of int to ExactPosterior
        By order.
    order : int or None
        The recommended one.
    """
    models = {k: e.model for k, e in exact.items()}
    highest = models[max(models)]
    resampling = Resampling(highest.reduced, highest.factors.monomials)
    left_out = _LeftOut.of(axis, exact, order)
    for chunk in points:
        data = separable.axis_data(chunk, axis.data.axis)
        design = replace(data, frame=axis.data.frame).design(highest.order)
        sd = np.ones(len(data)) if axis.data.sd is None or data.sd is None else data.sd
        left_out.add(design, data.t, sd, data.labels)
        if order is not None:
            resampling.add(np.column_stack([design, data.t]) / sd[:, None], np.log(sd))
    prediction = left_out.predictions()
    if order is None:
        return Defence(prediction)
    integrals = {k: e.log_integral for k, e in exact.items()}
    return Defence(
        prediction,
        tau_sensitivity(models) if axis.rule.scaled else None,
        points_that_matter=left_out.matter,
        resampled=(bootstrap_of(resampling.drawn(rng, RESAMPLES), models, "point"),),
        beyond=beyond(axis.data, integrals, axis.noise, axis.rule),
        further_points=left_out.changing - len(left_out.matter),
    )


@dataclass(eq=False)
class _LeftOut:
    """Leave-one-out of every order, summed up over chunks.

    Terms are summed as those of one order and the others' differences from them, which keep
    their digits where all orders predict alike.
    """

    exact: Mapping[int, ExactPosterior]
    leaving: dict[int, Leaving]
    order: int | None
    n: int
    mean: Array
    squares: Array
    spent: Array
    refitted: Array
    exists: bool = True
    changing: int = 0
    matter: tuple[Removal, ...] = ()

    @classmethod
    def of(cls, axis: Axis, exact: Mapping[int, ExactPosterior], order: int | None) -> _LeftOut:
        data, size = axis.data, len(exact)
        sd = data.deviations
        leaving = {k: Leaving.of(e, data.design(k), sd) for k, e in exact.items()}
        mean, squares, spent, refitted = np.split(
            np.zeros((size + 3, size)), [1, size + 1, size + 2]
        )
        return cls(exact, leaving, order, 0, mean[0], squares, spent[0], refitted[0])

    def add(self, design: Array, t: Array, sd: Array, labels: Sequence[str]) -> None:
        """Take in a chunk, its design that of the highest order."""
        found = [self._terms(i, design, t, sd) for i in range(len(self.exact))]
        terms = np.array([one for one in found if one is not None])
        if len(terms) < len(found):
            self.exists = False
            return
        first = terms[self._first].copy()
        self._sum(np.where(np.arange(len(terms))[:, None] == self._first, first, terms - first))
        if self.order is not None:
            self._look(terms, self.order, labels)

    def _terms(self, place: int, design: Array, t: Array, sd: Array) -> Array | None:
        """Terms of an order, and what they cost; None where they don't exist."""
        k, exact = list(self.exact.items())[place]
        model, design = exact.model, design[:, : exact.model.size]
        found = self.leaving[k].terms(design, t, sd)
        if found is None:
            return None
        out, inside, moved = found
        if moved.any():
            rows = np.column_stack([design, t])[moved] / sd[moved, None]
            rest = without_each(model.reduced, model.factors.monomials, rows, np.log(sd[moved]))
            without = log_evidences(rest.reduced(k), model.noise, model.prior, FINE)
            out[moved] = exact.log_integral - without
        self.spent[place] += float((inside - out).sum())
        self.refitted[place] += int(moved.sum())
        return out

    @property
    def _first(self) -> int:
        """Place of the order whose terms stand as they are."""
        return 0 if self.order is None else list(self.exact).index(self.order)

    def _sum(self, terms: Array) -> None:
        """Add to means and squares about them (Chan, Golub & LeVeque 1983)."""
        count = terms.shape[1]
        mean = terms.mean(axis=1)
        about = terms - mean[:, None]
        step, total = mean - self.mean, self.n + count
        self.squares = (
            self.squares + about @ about.T + np.outer(step, step) * self.n * count / total
        )
        self.mean = self.mean + step * count / total
        self.n = total

    def _look(self, terms: Array, order: int, labels: Sequence[str]) -> None:
        """Find the points without which another order would win."""
        integrals = np.array([e.log_integral for e in self.exact.values()])
        table = integrals[:, None] - terms
        lead = table.max(axis=0) - table[self._first]
        changed = np.flatnonzero(lead > 0)
        self.changing += len(changed)
        some = changed[np.argsort(-lead[changed], kind="stable")[:LISTED]]
        without = dict(zip(self.exact, table[:, some], strict=True))
        found = removals([labels[i] for i in some.tolist()], [1] * len(some), without, order)
        strongest = sorted((*self.matter, *found), key=lambda r: -r.log_bayes_factor)
        self.matter = tuple(strongest[:LISTED])

    def predictions(self) -> dict[int, Prediction]:
        """Compare the orders' totals; none where an order is undetermined without a point."""
        if not self.exists:
            return {}
        orders, first = list(self.exact), self._first
        # Each order's terms, as a combination of what was summed.
        parts = np.eye(len(orders))
        parts[:, first] = 1.0
        totals = self.n * (parts @ self.mean)
        best = parts[int(totals.argmax())]
        out = {}
        for i, k in enumerate(orders):
            loo = TotalLeaveOneOut(
                float(totals[i]), self._se(parts[i]), float(self.spent[i]), int(self.refitted[i])
            )
            gap = parts[i] - best
            out[k] = Prediction(loo, self.n * float(gap @ self.mean), self._se(gap), None, None)
        return out

    def _se(self, part: Array) -> float:
        """Give the standard error of a combination's sum: sqrt(n) times its sd (n - 1)."""
        return math.sqrt(max(float(part @ self.squares @ part), 0.0) * self.n / (self.n - 1))
