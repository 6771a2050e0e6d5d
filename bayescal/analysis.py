"""From points and settings to a comparison: the one place that loops over orders."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.comparison.argument import argue
from bayescal.comparison.caveats import caveats, notes
from bayescal.comparison.criteria import criteria
from bayescal.comparison.defence import Groups, defend
from bayescal.comparison.evidence import probabilities
from bayescal.comparison.goodness import goodness_of_fit, reference_sigma, scatter
from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.comparison.verdict import judge
from bayescal.errors import InputError
from bayescal.inference.least_squares import LeastSquaresFit, factorise, solve
from bayescal.inference.model import LinearModel
from bayescal.inference.posterior import Posterior, sample_posterior
from bayescal.models import separable
from bayescal.models.basis import legendre_design
from bayescal.models.linear import AxisData
from bayescal.models.noise import SPAN_BOUNDS, NoiseLevel
from bayescal.models.priors import PriorRule
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import StatedPrior

Progress: TypeAlias = Callable[[str, int], None]
DEFAULT_ORDERS = range(1, 6)
DEFAULT_ESS = 4000
HIGHEST_ORDER = 20


@dataclasses.dataclass(frozen=True)
class Settings:
    """What the user decides beside the data.

    Attributes
    ----------
    sigma : float or str or None
        Known sigma, px; ``"inferred"``; or None: the file's deviations where it
        has them, else inferred.
    prior : str or None
        ``"field"``, ``"flat"`` or ``"stated"``; None: the setup's stated prior
        where it has one, else field.
    tau : float or None
        Fixed tau of the field prior; None: inferred.
    seed : int
    ess : int
        Effective samples wanted of every parameter.
    defend : bool
        Whether to answer a referee's questions too.
    """

    sigma: float | str | None = None
    prior: str | None = None
    tau: float | None = None
    seed: int = 0
    ess: int = DEFAULT_ESS
    defend: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.sigma, str) and self.sigma != "inferred":
            raise InputError(f"sigma must be 'inferred' or a number of px, not {self.sigma!r}")
        if not 100 <= self.ess <= 1_000_000:
            raise InputError(f"ess must be from 100 to 1000000, not {self.ess}")
        if self.seed < 0:
            raise InputError(f"seed must not be negative, but is {self.seed}")


def checked_orders(orders: Iterable[int]) -> tuple[int, ...]:
    """Sort the orders wanted and refuse those out of range.

    Raises
    ------
    InputError
        Where there is none, or one is not from 1 to 20.
    """
    wanted = tuple(sorted({int(k) for k in orders}))
    if not wanted:
        raise InputError("no order is given; give at least one, such as 1-5")
    if wanted[0] < 1 or wanted[-1] > HIGHEST_ORDER:
        bad = wanted[0] if wanted[0] < 1 else wanted[-1]
        raise InputError(f"order {bad} is out of range; orders go from 1 to {HIGHEST_ORDER}")
    return wanted


def analyse_points(
    points: Correspondences,
    orders: dict[str, tuple[int, ...]],
    settings: Settings,
    progress: Progress | None,
) -> Comparison:
    """Compare the orders wanted of each axis of the separable family.

    Parameters
    ----------
    points : Correspondences
    orders : dict of str to tuple of int
        Ascending orders by axis.
    settings : Settings
    progress : callable or None
        Called with axis and order before each model is sampled.

    Returns
    -------
    Comparison
    """
    data = {axis: separable.axis_data(points, axis) for axis in orders}
    for axis, wanted in orders.items():
        data[axis].check(wanted[-1])  # refuse before anything is sampled
    groups = _groups(points)
    # One thread: a sum split over cores rounds differently from machine to machine.
    with threadpool_limits(1):
        axes = {
            axis: _compare_axis(
                data[axis],
                "rc".index(axis),
                wanted,
                settings,
                points.setup.priors.get(axis),
                groups,
                progress,
            )
            for axis, wanted in orders.items()
        }
    assumed = notes(points, axes.values())
    return Comparison(axes, separable.NAME, points, settings.seed, settings.ess, assumed)


def analyse_arrays(data: AxisData, orders: Sequence[int], settings: Settings) -> Comparison:
    """Compare orders of a generic one-axis problem.

    Parameters
    ----------
    data : AxisData
    orders : sequence of int
        Ascending.
    settings : Settings

    Returns
    -------
    Comparison
        With the single axis ``"y"``.
    """
    with threadpool_limits(1):
        result = _compare_axis(data, 0, orders, settings, None, None, None)
    assumed = (f"y: its span, {data.size:.6g}, stands for the image size in the prior",)
    return Comparison({"y": result}, "polynomial", None, settings.seed, settings.ess, assumed)


def _compare_axis(
    data: AxisData,
    key: int,
    orders: Sequence[int],
    settings: Settings,
    stated: StatedPrior | None,
    groups: Groups | None,
    progress: Progress | None,
) -> AxisComparison:
    data, noise, noise_source = _noise(data, settings)
    rule = _prior_rule(data, settings, stated)
    factors = factorise(data, orders[-1])
    priors = {k: rule.of_order(k) for k in orders}  # refuses a stated prior that is too short
    fits = {k: solve(factors, k, noise.value) for k in orders}
    reference = reference_sigma(noise, fits[orders[-1]])
    models = {k: LinearModel(factors, k, noise, priors[k], data.symbol) for k in orders}
    posteriors: dict[int, Posterior] = {}
    for k in orders:
        if progress is not None:
            progress(data.axis, k)
        # Keyed by axis and order, so that the other orders compared change no draw.
        seed = np.random.SeedSequence(settings.seed, spawn_key=(key, k))
        posteriors[k] = sample_posterior(models[k], np.random.default_rng(seed), settings.ess)
    chances, evidences = _probabilities(posteriors)
    found = {k: criteria(fits[k], noise, factors.n, factors.log_sd) for k in orders}
    results = tuple(
        OrderResult(
            k,
            fits[k],
            _rss_px2(data, fits[k]),
            goodness_of_fit(fits[k], fits[orders[-1]], reference),
            found[k],
            posteriors[k],
            chances[k] if chances is not None else None,
        )
        for k in orders
    )
    verdict = judge(chances, evidences, found, caveats(results, noise))
    defence = None
    if settings.defend:
        if progress is not None:
            progress(data.axis, 0)
        rng = np.random.default_rng(np.random.SeedSequence(settings.seed, spawn_key=(key, 0)))
        defence = defend(
            data, models, posteriors, rule, verdict.order, verdict.plausible, groups, rng
        )
        verdict = argue(verdict, defence, len(data), data.size)
    return AxisComparison(
        data, noise, noise_source, rule, reference, scatter(data), results, verdict, defence
    )


def _groups(points: Correspondences) -> Groups | None:
    """Form the groups of points that share a cause of error; None where they say nothing."""
    source, names = points.causes()
    unique, index = np.unique(np.array(names), return_inverse=True)
    if not 1 < len(unique) < len(points):
        return None
    members = (index == np.arange(len(unique))[:, None]).astype(float)
    return Groups(source, tuple(unique.tolist()), members)


def _noise(data: AxisData, settings: Settings) -> tuple[AxisData, NoiseLevel, str]:
    """Noise level of an axis, the data with or without deviations, and why, in words."""
    has_own = data.sd is not None
    if settings.sigma is None and has_own:
        return data, NoiseLevel.known(1.0), "known per point, from the data"
    ignored = "; the points' own deviations are not used, as asked" if has_own else ""
    data = dataclasses.replace(data, sd=None)
    if isinstance(settings.sigma, int | float):
        level = NoiseLevel.known(float(settings.sigma))
        return data, level, f"known, {settings.sigma:g} px{ignored}"
    if data.axis == "y":
        level = NoiseLevel.inferred((SPAN_BOUNDS[0] * data.size, SPAN_BOUNDS[1] * data.size))
    else:
        level = NoiseLevel.inferred()
    return data, level, f"inferred{ignored}"


def _prior_rule(data: AxisData, settings: Settings, stated: StatedPrior | None) -> PriorRule:
    default = "stated" if stated is not None and settings.tau is None else "field"
    centre = data.size / 2 if data.size_known else float(data.t.min() + np.ptp(data.t) / 2)
    return PriorRule(settings.prior or default, data.size, centre, settings.tau, stated)


def _probabilities(
    posteriors: dict[int, Posterior],
) -> tuple[dict[int, float] | None, dict[int, float] | None]:
    """Probability and log evidence by order; None where the prior has no evidence."""
    evidences = {}
    for k, posterior in posteriors.items():
        value = posterior.exact.log_evidence
        if value is None:
            return None, None
        evidences[k] = value
    return dict(zip(evidences, probabilities(list(evidences.values())), strict=True)), evidences


def _rss_px2(data: AxisData, fit: LeastSquaresFit) -> float:
    if data.sd is None:
        return fit.rss
    return float(np.sum(residuals(data, fit) ** 2))


def residuals(data: AxisData, fit: LeastSquaresFit) -> Array:
    """Measured less predicted pixels at the maximum-likelihood coefficients.

    Parameters
    ----------
    data : AxisData
    fit : LeastSquaresFit

    Returns
    -------
    Array
        ``(n_points,)``, px.
    """
    design = legendre_design(data.domain.scale(data.x), fit.order)
    return data.t - design @ fit.amplitudes
