"""What joint models of r and c are made of: their axes, noise levels, and the models themselves."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.cameras.pinhole import PinholeGeometry, Radial
from bayescal.comparison.criteria import Criteria
from bayescal.comparison.goodness import GoodnessOfFit, chi_squared
from bayescal.comparison.key import STATED
from bayescal.comparison.settings import Settings, check_resolved, noise_level, prior_rule
from bayescal.density.free_position import FreePositionModel
from bayescal.density.gaussian_pinhole import GaussianPinhole
from bayescal.density.moving_axis import MovingAxis
from bayescal.density.pinhole import PinholeModel
from bayescal.density.pinhole_coordinates import suited
from bayescal.density.pinhole_fit import JointData, PinholeFit, fit_pinhole
from bayescal.density.position_search import best_position, linearised
from bayescal.density.robust_pinhole import RobustPinhole
from bayescal.errors import InputError
from bayescal.linear.least_squares import factorise, only_rounding
from bayescal.linear.model import LinearModel
from bayescal.noise.choice import NoiseChoice
from bayescal.noise.level import WHOLE_PIXEL, NoiseLevel
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials import bivariate, separable
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from bayescal.prior.camera import PinholePrior, pinhole_prior, position_prior

LINEAR = {separable.NAME: separable.axis_data, bivariate.NAME: bivariate.axis_data}
Wanted = list[tuple[tuple[int, ...], int, int]]  # orders as named, of r, of c


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a linear family: its data, noise level and prior rule.

    Attributes
    ----------
    data : AxisData
    noise : NoiseLevel
    rule : PriorRule
    source : str
        How the noise level was chosen, in words.
    """

    data: AxisData
    noise: NoiseLevel
    rule: PriorRule
    source: str

    def model(self, order: int) -> LinearModel:
        """Make the likelihood model of an order."""
        self.data.check(order)
        prior = self.rule.of_degrees(self.data.degrees(order))
        return LinearModel(factorise(self.data, order), order, self.noise, prior, self.data.symbol)


@dataclass(frozen=True, eq=False)
class NoiseLevels:
    """Pixels of both axes with their noise levels, and how these were chosen, in words."""

    data: JointData
    words: tuple[str, str]


def linear_axes(
    points: Correspondences, family: str, settings: Settings, highest: int
) -> tuple[Axis, Axis]:
    """Set up both axes of a linear family, at the noise levels of the highest order."""
    out = []
    for axis in AXES:
        data = LINEAR[family](points, axis)
        other = separable.axis_data(points, "c" if axis == "r" else "r").x
        own = separable.axis_data(points, axis)
        usable, level, words = noise_level(own, settings, other, min(highest, 5))
        stated = points.setup.priors.get(axis) if family == separable.NAME else None
        rule = prior_rule(data, settings, stated)
        out.append(Axis(replace(data, sd=usable.sd), level, rule, words))
    return out[0], out[1]


def noise_levels(points: Correspondences, settings: Settings, highest: int) -> NoiseLevels:
    """Noise levels of a joint model: as the separable family's where its regressors exist."""
    pixels = np.stack([points.checked_pixel(axis) for axis in AXES])
    sds, levels, words = [], [], []
    for i, axis in enumerate(AXES):
        try:
            own = separable.axis_data(points, axis)
            other = separable.axis_data(points, AXES[1 - i]).x
            usable, level, text = noise_level(own, settings, other, min(highest, 5))
            sd = usable.sd
        except InputError:
            if points.world_sigma() is not None or settings.sigma in ("replicates", "scale"):
                raise
            sd = points.sigma.get(axis) if settings.sigma is None else None
            level, text = _plain_level(settings, sd, separable.axis_pixel(points, axis))
            if settings.choice.robust:
                level = level.on_readings(pixels[i], sd)
        if level.mass < 1:
            text += f", above the rounding of whole readings ({WHOLE_PIXEL:.2g} px)"
        sds.append(sd)
        levels.append(level)
        words.append(text)
    data = JointData(frozen(pixels), (sds[0], sds[1]), (levels[0], levels[1]))
    return NoiseLevels(data, (words[0], words[1]))


def _plain_level(settings: Settings, sd: Array | None, pixel: float) -> tuple[NoiseLevel, str]:
    if sd is not None:
        return NoiseLevel.known(1.0), "known per point, from the data"
    if isinstance(settings.sigma, float):
        return NoiseLevel.known(settings.sigma), f"known, {settings.sigma:g} px"
    return NoiseLevel.inferred_in(pixel), "inferred"


def joint_data(axes: tuple[Axis, Axis]) -> JointData:
    """Pixels of both axes with their noise levels."""
    r, c = axes
    return JointData(np.stack([r.data.t, c.data.t]), (r.data.sd, c.data.sd), (r.noise, c.noise))


def orders_of(orders: Wanted, axis: int) -> list[int]:
    """Orders wanted of an axis: 0 is r, 1 is c."""
    return sorted({(k, m)[axis] for _, k, m in orders})


def check_orders(axes: tuple[Axis, Axis], orders: Wanted) -> None:
    """Refuse orders that the points can't determine.

    Raises
    ------
    InputError
    """
    for i, axis in enumerate(axes):
        axis.data.check(max(orders_of(orders, i)))


def joint_criteria(data: JointData, rss: Array, k: int) -> Criteria:
    """Likelihood criteria of K parameters, from the weighted `rss` of each axis, ``(2,)``.

    n counts points. An axis that is fitted exactly leaves none.
    """
    largest = np.abs(data.pixels / data.deviations).max(axis=1)
    if any(map(only_rounding, rss.tolist(), [data.n] * 2, largest.tolist())):
        return Criteria(k)
    value = data.log_likelihood(rss)
    return Criteria(k, value, -2 * value + 2 * k, None, -2 * value + k * math.log(data.n))


def joint_goodness(data: JointData, rss: Array, k: int) -> GoodnessOfFit | None:
    """Chi-squared of both axes with `k` parameters, from their `rss`; None if a sigma is inferred.

    Where parameters are not linear, its degrees of freedom are approximate (Andrae et al. 2010).
    """
    if any(level.value is None for level in data.levels):
        return None
    chi2 = sum(
        q / level.value**2
        for q, level in zip(rss.tolist(), data.levels, strict=True)
        if level.value is not None
    )
    known = all(level.source == "known" for level in data.levels)
    return chi_squared(chi2, 2 * data.n - k, known=known)


def moving_axes(
    points: Correspondences, axes: tuple[Axis, Axis], orders: tuple[int, int]
) -> tuple[MovingAxis, MovingAxis]:
    """Both axes of a linear family as functions of the camera position."""
    r, c = (
        MovingAxis(a.data, points.world, i, k, a.noise, a.rule.of_degrees(a.data.degrees(k)))
        for i, (a, k) in enumerate(zip(axes, orders, strict=True))
    )
    return r, c


def free_model(
    points: Correspondences, axes: tuple[Axis, Axis], orders: tuple[int, int]
) -> tuple[FreePositionModel, Array]:
    """Build a linear family's model at a free position; its least weighted squares, ``(2,)``."""
    prior, moving = position_prior(points), moving_axes(points, axes, orders)
    start = best_position(moving, prior)
    rss = [e @ e for e, _ in (linearised(axis, start) for axis in moving)]
    return FreePositionModel(moving, prior, frozen(start)), np.array(rss)


def pinhole_model(
    points: Correspondences,
    order: int,
    position: str,
    radial: Radial,
    data: JointData,
    settings: Settings,
) -> PinholeModel:
    """Build and fit a pinhole of one order."""
    prior: PinholePrior = pinhole_prior(points, settings.tau)
    fixed = frozen(points.setup.position) if position == STATED else None
    geometry = PinholeGeometry(
        points.world, prior.orientation, prior.half_diagonal, order, radial, fixed
    )
    fit: PinholeFit = fit_pinhole(points, geometry, prior, data)
    for axis, level, rss in zip(AXES, data.levels, fit.rss.tolist(), strict=True):
        check_resolved(f"{points.source}: axis {axis}", level, rss, data.n, order)
    geometry, fit = suited(geometry, prior.position, fit)
    if not settings.choice.robust:
        return GaussianPinhole.of(geometry, prior, data, fit)
    noise = NoiseChoice(settings.noise, settings.nu, settings.bad_offset).model(1.0)
    return RobustPinhole.of(geometry, prior, data, fit, noise)
