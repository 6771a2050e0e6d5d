"""What joint models of r and c are made of: their axes, noise levels, and the models themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.cameras.pinhole import PinholeGeometry, Radial
from bayescal.comparison.choosing import check_exact_world, check_resolved, noise_level, prior_rule
from bayescal.comparison.criteria.goodness import GoodnessOfFit, chi_squared
from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.key import STATED
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Once, now
from bayescal.density.free_position import FreePositionModel
from bayescal.density.joint_data import JointData
from bayescal.density.moving_axis import MovingAxis
from bayescal.density.pinholes.coordinates import suited
from bayescal.density.pinholes.fit import PinholeFit, fit_pinhole
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.density.pinholes.laplace import Normal
from bayescal.density.pinholes.robust import Framed, RobustPinhole
from bayescal.density.position_search import best_position, linearised
from bayescal.errors import InputError
from bayescal.linear.least_squares import only_rounding
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.level import WHOLE_PIXEL, NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials import bivariate, separable
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.polynomials.whole import Whole
from bayescal.prior.camera import PinholePrior, pinhole_prior, position_prior

LINEAR = {separable.NAME: separable.axis_data, bivariate.NAME: bivariate.axis_data}


class Wanted(NamedTuple):
    """Orders of a model as it names them, of r and of c."""

    named: tuple[int, ...]
    r: int
    c: int

    @property
    def pair(self) -> tuple[int, int]:
        """Of r and of c."""
        return self.r, self.c


@dataclass(frozen=True, eq=False)
class NoiseLevels:
    """Pixels of both axes with their noise levels, and how these were chosen, in words."""

    data: JointData
    words: tuple[str, str]


def reduced_name(family: str, axis: str) -> str:
    """Give the name of an axis of a family among what many points were reduced to."""
    return f"{family}, {axis}"


def linear_axes(
    points: Correspondences,
    family: str,
    settings: Settings,
    highest: int,
    whole: Mapping[str, Whole] | None = None,
) -> tuple[Axis, Axis]:
    """Set up both axes of a linear family, at the noise levels of the highest order.

    With the `whole` of each, by `reduced_name`, these points are a sample of it.
    """
    out = []
    for axis in AXES:
        data = LINEAR[family](points, axis)
        other = separable.axis_data(points, PIXEL_AXES[axis].other).x
        own = separable.axis_data(points, axis)
        if whole is not None:
            data = own = data.sampled_from(whole[reduced_name(family, axis)])
        chosen = noise_level(own, settings, other, min(highest, 5))
        chosen = check_exact_world(chosen)
        stated = points.setup.priors.get(axis) if family == separable.NAME else None
        rule, data = prior_rule(data, settings, stated), replace(data, sd=chosen.data.sd)
        out.append(Axis(data, chosen.level, chosen.words, rule, family, highest))
    return out[0], out[1]


def noise_levels(points: Correspondences, settings: Settings, highest: int) -> NoiseLevels:
    """Noise levels of a joint model: as the separable family's where its regressors exist."""
    pixels = np.stack([points.checked_pixel(axis) for axis in AXES])
    sds, levels, words = [], [], []
    for i, axis in enumerate(AXES):
        try:
            own = separable.axis_data(points, axis)
            other = separable.axis_data(points, AXES[1 - i]).x
            chosen = noise_level(own, settings, other, min(highest, 5))
            usable, level, text, _ = check_exact_world(chosen)
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
    pixels, sd = np.stack([r.data.t, c.data.t]), (r.data.sd, c.data.sd)
    wholes = r.data.whole, c.data.whole
    many = None if wholes[0] is None or wholes[1] is None else (wholes[0], wholes[1])
    return JointData(pixels, sd, (r.noise, c.noise), many)


def checked_axes(axes: tuple[Axis, Axis], orders: Sequence[Wanted]) -> tuple[Axis, Axis]:
    """Both axes up to the highest orders wanted; refuse those the points can't determine."""
    r, c = (a.up_to(max(w.pair[i] for w in orders)) for i, a in enumerate(axes))
    for axis in (r, c):
        axis.data.check(axis.highest)
    return r, c


def joint_criteria(data: JointData, rss: Array, k: int) -> Criteria:
    """Likelihood criteria of K parameters, from the weighted `rss` of each axis, ``(2,)``.

    n counts points. An axis that is fitted exactly leaves none.
    """
    if any(map(only_rounding, rss.tolist(), [data.n] * 2, data.largest)):
        return Criteria(k)
    value = data.log_likelihood(rss)
    return Criteria.of(k, value, data.n, inferred=any(data.inferred), across=True)


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
        MovingAxis(a.data, points.world, i, k, a.noise, a.prior(k))
        for i, (a, k) in enumerate(zip(axes, orders, strict=True))
    )
    return r, c


def free_model(
    points: Correspondences, axes: tuple[Axis, Axis], orders: tuple[int, int], once: Once = now
) -> tuple[FreePositionModel, Array]:
    """Build a linear family's model at a free position; its least weighted squares, ``(2,)``."""
    prior, moving = position_prior(points), moving_axes(points, axes, orders)
    start = once("position", Array, partial(best_position, moving, prior))
    rss = [e @ e for e, _ in (linearised(axis, start) for axis in moving)]
    return FreePositionModel(moving, prior, frozen(start)), np.array(rss)


def linear_residuals(
    points: Correspondences, axes: tuple[Axis, Axis], orders: tuple[int, int], position: Array
) -> Array:
    """Least squares' residuals of r and c at a camera position, ``(2, n_points)``, px."""
    out = []
    for moving in moving_axes(points, axes, orders):
        data, design = moving.data, moving.design(position[None])[0]
        sd = data.deviations
        b, *_ = np.linalg.lstsq(design / sd[:, None], data.t / sd, rcond=None)
        out.append(data.t - design @ b)
    return np.stack(out)


class FittedPinhole(NamedTuple):
    """A pinhole of one order, fitted: what each model of it begins with."""

    geometry: PinholeGeometry
    prior: PinholePrior
    data: JointData
    fit: PinholeFit


def gaussian_pinhole(fitted: FittedPinhole, once: Once = now) -> GaussianPinhole:
    """Build a fitted pinhole's model."""
    frame = once("frame", Normal, partial(GaussianPinhole.frame_of, *fitted))
    return GaussianPinhole(*fitted, frame, GAUSSIAN)


def robust_pinhole(fitted: FittedPinhole, noise: NoiseModel, once: Once = now) -> RobustPinhole:
    """Build a fitted pinhole's model under noise without a closed form."""
    framed = once("frame", Framed, partial(RobustPinhole.framed, *fitted, noise))
    return RobustPinhole(*fitted, framed.frame, noise, framed.fits)


def fitted_pinhole(
    points: Correspondences,
    order: int,
    position: str,
    radial: Radial,
    data: JointData,
    settings: Settings,
    once: Once = now,
) -> FittedPinhole:
    """Fit a pinhole of one order."""
    prior = pinhole_prior(points, settings.tau)
    fixed = frozen(points.setup.position) if position == STATED else None
    geometry = PinholeGeometry(
        points.world, prior.orientation, prior.half_diagonal, order, radial, fixed
    )
    fit = once("fit", PinholeFit, partial(fit_pinhole, points, geometry, prior, data))
    for axis, level, rss in zip(AXES, data.levels, fit.rss.tolist(), strict=True):
        check_resolved(f"{points.source}: axis {axis}", level, rss, data.n, order)
    geometry, fit = suited(geometry, prior.position, fit)
    return FittedPinhole(geometry, prior, data, fit)
