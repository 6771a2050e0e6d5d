"""One axis's bad points: orders times ways of treating bad points, and records of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.adequacy.block import adequacy
from bayescal.comparison.adequacy.normality import NAME as NORMALITY
from bayescal.comparison.finding import Finding, ordered
from bayescal.comparison.findings.misfit import concerning
from bayescal.comparison.judged import Judged, with_probabilities
from bayescal.comparison.judging import judge_all
from bayescal.comparison.key import Key
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.candidates import GaussianOrder, RobustOrder
from bayescal.comparison.outliers.records import (
    Elimination,
    PointRecord,
    RobustView,
    eliminate,
    point_records,
)
from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.comparison.outliers.request import OutlierRequest
from bayescal.comparison.outliers.results import AxisOutliers
from bayescal.comparison.outliers.shared_errors import SharedError, shared_errors
from bayescal.comparison.outliers.treatments import Treatment
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.quadrature import FINE
from bayescal.linear.reweighting import Rows
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.rows import ALL

# How tables name the treatments by noise models that know bad points, in their order.
NAMED = "Student-t noise", "the outlier mixture"


@dataclass(frozen=True, eq=False)
class AxisStudy:
    """One axis under every treatment of its bad points.

    Attributes
    ----------
    axis : Axis
    other : Array
        Regressor of the other axis, ``(n_points,)``.
    store : Store
        Keeps what is sampled.
    """

    points: Correspondences
    axis: Axis
    other: Array
    request: OutlierRequest
    settings: Settings
    store: Store

    @cached_property
    def plain(self) -> list[GaussianOrder]:
        """Orders under Gaussian noise, of all points."""
        return [GaussianOrder(self.axis, k, GAUSSIAN) for k in self.request.orders]

    @cached_property
    def robust(self) -> tuple[dict[int, RobustOrder], ...]:
        """Orders under each noise model that knows bad points."""
        orders, noises = self.request.orders, self.request.noises
        return tuple({k: RobustOrder.of(self.axis, k, noise) for k in orders} for noise in noises)

    def found(self, tell: Callable[[str], None]) -> AxisOutliers:
        """Find the bad points; `tell` is called before each noise model is sampled."""
        axis, data = self.axis, self.axis.data
        axis.check_resolved()
        rule = RejectionRule(self.request.rejection.significance, sigma=axis.noise.plug_in)
        elimination = eliminate(data, self.request.orders, rule)
        gaussian, without = self._gaussian(), self._eliminated(elimination)
        sampled = [*self._sampled(tell)]
        order = max((gaussian, *sampled), key=lambda t: t.total).order
        view = self._view(order)
        loo = {c.order: left for c in self.plain if (left := c.left_out(self.store)) is not None}
        records = point_records(data, elimination, order, loo, gaussian.log_evidence, view)
        return AxisOutliers(
            data,
            axis.noise,
            axis.rule,
            axis.source,
            order,
            records,
            elimination,
            (gaussian, without, *sampled),
            self._shared(records, order),
            self._findings(gaussian.order),
        )

    def _gaussian(self) -> Treatment:
        judged = [c.beside(self.store, self.settings) for c in self.plain]
        return Treatment("Gaussian noise", len(self.axis.data), with_probabilities(judged))

    def _eliminated(self, elimination: Elimination) -> Treatment:
        removed = len(elimination.highest.removed)
        words = f" without {removed} eliminated" if removed else ", nothing eliminated"
        left = _without(self.axis, self.request.orders, elimination)
        return Treatment(f"Gaussian noise{words}", len(self.axis.data) - removed, left)

    def _sampled(self, tell: Callable[[str], None]) -> Iterator[Treatment]:
        data = self.axis.data
        for words, orders in zip(NAMED, self.robust, strict=True):
            tell(data.axis)
            judged = judge_all(orders.values(), self.store, self.settings)
            yield Treatment(words, len(data), judged)

    def _view(self, order: int) -> RobustView:
        """Say what both robust noise models say of every point at an order."""
        heavy, mixture = (orders[order] for orders in self.robust)
        draws = [model.posterior(self.store, self.settings) for model in (heavy, mixture)]
        find = partial(_robust_view, heavy, draws[0], mixture, draws[1])
        return self.store.once(f"{self.axis.data.axis} robust view", RobustView, find)

    def _shared(self, records: tuple[PointRecord, ...], order: int) -> tuple[SharedError, ...]:
        """Find errors that points of one coordinate share, at an order under the mixture."""
        data, level = self.axis.data, self.axis.noise
        posterior = self.robust[-1][order].posterior(self.store, self.settings)
        scale = level.value or posterior[level.parameter].mean
        slope = _slope(data, posterior, order) / self._depth
        return shared_errors(data, records, self.points.world, slope, scale * data.deviations)

    def _findings(self, order: int) -> tuple[Finding, ...]:
        """Say what is wrong with the curve of an order, whatever points are bad."""
        data, rng = self.axis.data, self._key.rng(self.settings.seed, 1)
        fit, groups = self.axis.fit(order), self.points.groups
        tests = adequacy(data, fit, self.axis.noise, self.other, self._depth, groups, rng=rng)
        # Bad points alone make the noise look as if it were not normal.
        return ordered(concerning([test for test in tests if test.name != NORMALITY]))

    @property
    def _depth(self) -> Array:
        return self.points.camera_frame()[:, 2]

    @property
    def _key(self) -> Key:
        return Key.of_axis(self.axis.data.axis, 0, GAUSSIAN.name)


def _without(axis: Axis, orders: Sequence[int], elimination: Elimination) -> tuple[Judged, ...]:
    """Evidence of the points that the highest order keeps; domain and prior stay."""
    members = np.zeros((1, len(axis.data)))
    members[0, list(elimination.highest.removed)] = 1
    sets = Rows.of(axis.data, orders[-1]).without(members)
    values = {k: log_evidences(sets.reduced(k), axis.noise, axis.prior(k), FINE) for k in orders}
    return with_probabilities(
        [
            Judged(
                key=Key.of_axis(axis.data.axis, k, GAUSSIAN.name),
                log_evidence=float(value[0]),
                log_evidence_error=0.0,
            )
            for k, value in values.items()
        ]
    )


def _robust_view(
    heavy: RobustOrder, heavy_draws: SampledPosterior, mixture: RobustOrder, draws: SampledPosterior
) -> RobustView:
    """Say what Student-t noise and the mixture say of every point."""
    full, model = draws.completed, mixture.model
    amplitudes = full[:, : model.size]
    covariance = np.atleast_2d(np.cov(amplitudes, rowvar=False))
    design = model.design[ALL]
    variance = ((design @ covariance) * design).sum(axis=1)
    bad = model.bad_probability(full)
    assert bad is not None, "the mixture knows bad points"
    return RobustView(
        design @ amplitudes.mean(axis=0),
        np.sqrt(variance),
        bad,
        heavy.model.weight(heavy_draws.completed),
    )


def _slope(data: AxisData, posterior: SampledPosterior, order: int) -> Array:
    """Slope of the mean prediction over the regressor at every point, px, ``(n_points,)``."""
    theta = posterior.chain.theta
    amplitudes = theta.reshape(-1, theta.shape[2])[:, : order + 1].mean(axis=0)
    derivative = np.polynomial.legendre.legder(amplitudes) / data.domain.half_range
    return np.asarray(np.polynomial.legendre.legval(data.domain.scale(data.x), derivative))
