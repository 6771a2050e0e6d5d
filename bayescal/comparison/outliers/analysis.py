"""From points to their bad ones: each axis, each order, each way of treating them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.comparison.defence.noise_evidence import NoiseEvidence, noise_evidence
from bayescal.comparison.leave_one_out import leave_one_out
from bayescal.comparison.outliers.records import (
    Elimination,
    RobustView,
    eliminate,
    point_records,
)
from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.comparison.outliers.results import AxisOutliers, OutlierStudy, Treatment
from bayescal.comparison.outliers.shared_errors import shared_errors
from bayescal.comparison.settings import Settings, check_resolved, noise_level, prior_rule
from bayescal.comparison.store import Store
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.least_squares import factorise, solve
from bayescal.linear.model import LinearModel
from bayescal.linear.quadrature import FINE
from bayescal.linear.reweighting import Rows
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import PriorRule


def find_outliers(
    points: Correspondences,
    names: Sequence[str],
    orders: tuple[int, ...],
    settings: Settings,
    noises: tuple[StudentT, OutlierMixture],
    rejection: RejectionRule,
    tell: Callable[[str], None],
    store: Store | None = None,
) -> OutlierStudy:
    """Study the bad points of each axis wanted.

    Parameters
    ----------
    points : Correspondences
    names : sequence of str
        Axes, of ``"r"`` and ``"c"``.
    orders : tuple of int
        Polynomial degrees, ascending.
    settings : Settings
    noises : tuple
        The two noise models that know bad points.
    rejection : RejectionRule
    tell : callable
        Called with the axis before each noise model is sampled.
    store : Store, optional
        Where posteriors come from; by default they are sampled.

    Returns
    -------
    OutlierStudy

    Raises
    ------
    InputError
        Where the points can't determine an order.
    """
    data = {name: axis_data(points, name) for name in AXES}
    for name in names:
        data[name].check(orders[-1])
    axes = {}
    with threadpool_limits(1):
        for name in names:
            other = data["c" if name == "r" else "r"].x
            axes[name] = _axis(
                points,
                noise_level(data[name], settings, other, orders[-1]),
                prior_rule(data[name], settings, points.setup.priors.get(name)),
                orders,
                noises,
                rejection,
                settings,
                tell,
                store or Store(),
            )
    return OutlierStudy(axes, points, rejection.significance, settings, noises)


def _axis(
    points: Correspondences,
    chosen: tuple[AxisData, NoiseLevel, str],
    rule: PriorRule,
    orders: tuple[int, ...],
    robust: tuple[NoiseModel, NoiseModel],
    rejection: RejectionRule,
    settings: Settings,
    tell: Callable[[str], None],
    store: Store,
) -> AxisOutliers:
    data, level, words = chosen
    factors = factorise(data, orders[-1])
    where, highest = f"{data.source}: axis {data.axis}", solve(factors, orders[-1], level.plug_in)
    check_resolved(where, level, highest.rss, len(data), orders[-1])
    exact = {
        k: exact_posterior(LinearModel(factors, k, level, rule.of_order(k), data.symbol))
        for k in orders
    }
    gaussian = _closed_form({k: e.log_integral for k, e in exact.items()})
    elimination = eliminate(
        data, orders, RejectionRule(rejection.significance, sigma=level.plug_in)
    )
    sampled = []
    for noise in robust:
        tell(data.axis)
        sampled.append(
            noise_evidence(data, level, rule, noise, orders, settings, store, beside=False)
        )
    heavy, mixture = sampled
    best = max((gaussian, heavy, mixture), key=lambda e: e.total)
    order = best.order
    removed = len(elimination.highest.removed)
    treatments = (
        Treatment("Gaussian noise", len(data), gaussian),
        Treatment(
            f"Gaussian noise without {removed} eliminated"
            if removed
            else "Gaussian noise, nothing eliminated",
            len(data) - removed,
            _without(data, level, rule, orders, elimination),
        ),
        Treatment("Student-t noise", len(data), heavy),
        Treatment("the outlier mixture", len(data), mixture),
    )
    view = _robust_view(mixture.posteriors[order], heavy.posteriors[order])
    left_out = {k: leave_one_out(data, e) for k, e in exact.items()}
    loo = {k: found for k, found in left_out.items() if found is not None}
    records = point_records(data, elimination, order, loo, gaussian.log_evidence, view)
    posterior = mixture.posteriors[order]
    scale = (
        float(posterior["sigma"].mean)
        if "sigma" in posterior.names
        else (float(posterior["scale"].mean) if "scale" in posterior.names else level.value or 1.0)
    )
    own = np.ones(len(data)) if data.sd is None else data.sd
    slope = _slope(data, posterior, order) / points.camera_frame()[:, 2]
    shared = shared_errors(data, records, points.world, slope, scale * own)
    return AxisOutliers(data, level, rule, words, order, records, elimination, treatments, shared)


def _closed_form(log_evidence: dict[int, float]) -> NoiseEvidence:
    return NoiseEvidence(GAUSSIAN.name, log_evidence, dict.fromkeys(log_evidence, 0.0), {}, {})


def _without(
    data: AxisData,
    level: NoiseLevel,
    rule: PriorRule,
    orders: tuple[int, ...],
    elimination: Elimination,
) -> NoiseEvidence:
    """Evidence of the points that the highest order keeps; domain and prior stay."""
    members = np.zeros((1, len(data)))
    members[0, list(elimination.highest.removed)] = 1
    sets = Rows.of(data, orders[-1]).without(members)
    return _closed_form(
        {k: float(log_evidences(sets.reduced(k), level, rule.of_order(k), FINE)[0]) for k in orders}
    )


def _robust_view(mixture: SampledPosterior, heavy: SampledPosterior) -> RobustView:
    model, other = mixture.model, heavy.model
    assert isinstance(model, RobustLinearModel), "noise_evidence samples these"
    assert isinstance(other, RobustLinearModel), "noise_evidence samples these"
    full = mixture.full.reshape(-1, mixture.full.shape[2])
    predicted = model.t - model.residuals(full)
    bad = model.bad_probability(full)
    assert bad is not None, "the mixture knows bad points"
    return RobustView(
        predicted.mean(axis=0),
        predicted.std(axis=0, ddof=1),
        bad.mean(axis=0),
        other.weight(heavy.full.reshape(-1, heavy.full.shape[2])).mean(axis=0),
    )


def _slope(data: AxisData, posterior: SampledPosterior, order: int) -> Array:
    """Slope of the mean prediction over the regressor at every point, px, ``(n_points,)``."""
    theta = posterior.chain.theta
    amplitudes = theta.reshape(-1, theta.shape[2])[:, : order + 1].mean(axis=0)
    derivative = np.polynomial.legendre.legder(amplitudes) / data.domain.half_range
    return np.asarray(np.polynomial.legendre.legval(data.domain.scale(data.x), derivative))
