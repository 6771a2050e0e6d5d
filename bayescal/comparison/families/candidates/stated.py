"""Linear families at the stated position, where r and c have nothing in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.comparison.criteria.information import robust_criteria
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.comparison.criteria.psis import of_both, sampled_leave_one_out
from bayescal.comparison.defence.stability import without_groups
from bayescal.comparison.families.candidates.joint import Likelihood, LinearPair, result_of
from bayescal.comparison.families.linearised import Linearised, of_pair
from bayescal.comparison.families.models import Wanted, checked_axes, joint_data
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.key import Key
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.candidates import GaussianOrder, RobustOrder
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.density.robust_pair import RobustPair, paired
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.points.correspondences import Correspondences


@dataclass(frozen=True, eq=False)
class ExactPair(LinearPair):
    """The product of two axes, each in closed form."""

    r: GaussianOrder
    c: GaussianOrder

    def judge(self, store: Store, settings: Settings) -> JointModel:  # noqa: ARG002
        """Say what the closed forms say; nothing is sampled."""
        r, c, data = self.r.exact, self.c.exact, joint_data(self.axes)
        rss = np.array([e.model.factors.rss(e.model.order) for e in (r, c)])
        count = r.model.size + c.model.size + sum(data.inferred)
        likelihood, place = Likelihood.of(data, rss, count), frozen(self.points.setup.position)
        loos = [None if self.reduced else axis.left_out(store) for axis in (self.r, self.c)]
        return JointModel(
            key=self.key,
            log_evidence=r.log_integral + c.log_integral,
            log_evidence_error=math.hypot(r.log_evidence_error or 0.0, c.log_evidence_error or 0.0),
            loo=None if loos[0] is None or loos[1] is None else of_both(loos[0], loos[1]),
            criteria=likelihood.criteria,
            goodness=likelihood.goodness,
            exact=(r, c),
            **self.at(place),
        )

    @property
    def approximate(self) -> float:
        """Log evidence, in closed form."""
        return self.r.exact.log_integral + self.c.exact.log_integral

    def without_groups(self, members: Array) -> Array:
        """Give the same without each group, `members` ``(n_groups, n_points)``."""
        named = zip(self.axes, self.wanted.pair, strict=True)
        return np.asarray(
            sum(without_groups(a.data, {k: a.linear(k)}, members)[k] for a, k in named)
        )

    def linearised(self) -> Linearised:
        """About its highest likelihood: of a sample, its own."""
        place = self.points.setup.position
        r, c = (replace(axis, data=axis.data.alone) for axis in self.axes)
        return of_pair(self.points, (r, c), self.wanted.pair, np.array(place), free=False)


@dataclass(frozen=True, eq=False)
class RobustStatedPair(LinearPair):
    """Independent draws of two axes, each sampled as a comparison of its orders would."""

    r: RobustOrder
    c: RobustOrder

    def judge(self, store: Store, settings: Settings) -> JointModel:
        """Say what the draws of both say."""
        pair = RobustPair((self.r.model, self.c.model))
        posterior = store.posterior(self.key, pair, partial(self._pair, pair, store, settings))

        def left_out() -> LeaveOneOut | None:
            r = sampled_leave_one_out(posterior, lambda full: pair.log_likelihoods(full)[0])
            c = sampled_leave_one_out(posterior, lambda full: pair.log_likelihoods(full)[1])
            return None if r is None or c is None else of_both(r, c)

        return result_of(
            self.key,
            posterior,
            Likelihood(robust_criteria(pair.names)),
            store.leave_one_out(self.key, left_out),
            posterior=posterior,
            **self.at(frozen(self.points.setup.position)),
        )

    def _pair(self, pair: RobustPair, store: Store, settings: Settings) -> SampledPosterior:
        """Sample both axes; never called where a run has kept the pair."""
        r, c = (axis.posterior(store, settings, beside=True) for axis in (self.r, self.c))
        return paired(r, c, pair)


def stated_pairs(
    family: str,
    axes: tuple[Axis, Axis],
    orders: Sequence[Wanted],
    points: Correspondences,
    settings: Settings,
    store: Store,  # noqa: ARG001 - nothing is searched for
) -> list[ExactPair] | list[RobustStatedPair]:
    """List the candidates of a linear family at the stated position."""
    pair = checked_axes(axes, orders)
    named = [
        LinearPair(Key(family, w.named, noise=settings.noise), points, pair, w) for w in orders
    ]
    wanted = [sorted({w.pair[i] for w in orders}) for i in (0, 1)]
    if settings.choice.robust:
        robust = [
            {k: RobustOrder.of(axis, k, settings.noise_model(axis.data)) for k in ks}
            for axis, ks in zip(pair, wanted, strict=True)
        ]
        return [
            RobustStatedPair(*p.parts, robust[0][p.wanted.r], robust[1][p.wanted.c]) for p in named
        ]
    exact = [
        {k: GaussianOrder(axis, k, GAUSSIAN) for k in ks}
        for axis, ks in zip(pair, wanted, strict=True)
    ]
    return [ExactPair(*p.parts, exact[0][p.wanted.r], exact[1][p.wanted.c]) for p in named]
