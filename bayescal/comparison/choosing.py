"""What settings and data choose for an axis: its noise level and its prior."""

from __future__ import annotations

import dataclasses
import math
import numbers
from typing import NamedTuple

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.linear.errors.effective_variance import with_effective_deviations, world_errors
from bayescal.linear.replicates import pure_error
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.noise.world_errors import WorldErrors
from bayescal.points.setup import LARGEST_PX, SMALLEST_PX, StatedPrior
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from bayescal.rounding import significant

# chi-squared beyond which rounding of the likelihood is felt.
LARGEST_CHI2 = 1e12
# What a known sigma may be, as a share of the span of y where y is not a pixel.
KNOWN_SHARE = (1e-12, 1e9)


class ChosenLevel(NamedTuple):
    """The noise level of an axis.

    Attributes
    ----------
    data : AxisData
        With deviations only where they are used.
    words : str
        How it was chosen.
    shape : NoiseModel
        Of the noise about it: the one asked for, or Gaussian beside errors of the world
        coordinates, where sigma is inferred.
    """

    data: AxisData
    level: NoiseLevel
    words: str
    shape: NoiseModel = GAUSSIAN


def noise_level(data: AxisData, settings: Settings, other: Array | None, order: int) -> ChosenLevel:
    """Choose the noise level of an axis.

    Parameters
    ----------
    other : Array or None
        The other axis's regressor, which replicates must share too.
    order : int
        The highest compared: its slope carries errors of world coordinates to pixels.

    Raises
    ------
    InputError
        Where these data do not give the level asked for.
    """
    pixels, level, source, _ = _pixel_noise(data, settings, other)
    shape = settings.noise_model(data)
    exact = data.x_sd is None or not data.x_sd.any()
    if (settings.choice.robust or not exact) and not data.generic:
        level = level.on_readings(pixels.t, pixels.sd)
    if exact:
        return ChosenLevel(pixels, level, source, shape)
    if level.source == "inferred":
        if settings.choice.robust:
            raise needs_sigma(data, f"{settings.noise} noise")
        source += "; beside it the errors of the world coordinates, as effective variances"
        return ChosenLevel(pixels, level, source, world_errors(pixels, level, order))
    alone = pixels.sd if pixels.sd is not None else np.full(len(data), level.plug_in)
    combined = with_effective_deviations(pixels, alone, order)
    source += "; with the errors of the world coordinates, as effective variances"
    if level.source != "scale":
        return ChosenLevel(combined, NoiseLevel.known(1.0), source, shape)
    scale = NoiseLevel.scale()
    if settings.choice.robust:
        scale = scale.on_readings(combined.t, combined.sd)
    return ChosenLevel(combined, scale, source, shape)


def needs_sigma(data: AxisData, what: str) -> InputError:
    """Make the complaint where a sigma can't be inferred beside errors of the world."""
    return InputError(
        f"{data.source}: axis {data.axis}: {what} can't have a sigma inferred beside errors of the "
        f"world coordinates; add --sigma PX or a column sigma_{data.axis}"
    )


def check_exact_world(chosen: ChosenLevel) -> ChosenLevel:
    """Refuse, for joint models, a sigma inferred beside errors of the world."""
    if chosen.shape.name == WorldErrors.name:
        raise needs_sigma(chosen.data, "a joint model")
    return chosen


def _pixel_noise(data: AxisData, settings: Settings, other: Array | None) -> ChosenLevel:
    """Noise level of the pixels alone."""
    wanted, has_own = settings.sigma, data.sd is not None
    if wanted == "scale":
        if not has_own:
            raise InputError(
                f"{data.source}: axis {data.axis}: sigma scale needs deviations to scale; add a "
                f"column sigma_{data.axis}"
            )
        words = "the points' own deviations times an inferred scale"
        return ChosenLevel(data, NoiseLevel.scale(), words)
    if wanted is None and has_own:
        return ChosenLevel(data, NoiseLevel.known(1.0), "known per point, from the data")
    ignored = "; the points' own deviations are not used, as asked" if has_own else ""
    data = dataclasses.replace(data, sd=None)
    if wanted == "replicates":
        if data.whole is not None:
            raise InputError(
                f"{data.source}: axis {data.axis}: replicates are sought among all points, of "
                "which only a sample is held; state --sigma or leave it inferred"
            )
        pure, dof = pure_error(data.x, other, data.t)
        if not pure:
            why = "do not differ" if dof else "don't exist: no two points share every regressor"
            raise InputError(
                f"{data.source}: axis {data.axis}: sigma can't come from replicates, which {why}; "
                "state --sigma or leave it inferred"
            )
        words = (
            f"{significant(pure, 3)} px, from replicates ({dof} dof), inferred with their "
            f"uncertainty{ignored}"
        )
        return ChosenLevel(data, NoiseLevel.replicates(pure, dof, data.pixel), words)
    if isinstance(wanted, numbers.Real):
        _check_known(data, float(wanted))
        words = f"known, {wanted:g} px{ignored}"
        return ChosenLevel(data, NoiseLevel.known(float(wanted)), words)
    return ChosenLevel(data, NoiseLevel.inferred_in(data.pixel), f"inferred{ignored}")


def _check_known(data: AxisData, sigma: float) -> None:
    """Refuse a sigma from which no double tells the residuals, or that dwarfs all pixels."""
    low, high = SMALLEST_PX, LARGEST_PX
    if not data.in_pixels:
        low, high = (data.size * share for share in KNOWN_SHARE)
    if not low <= sigma <= high:
        raise InputError(f"sigma must be from {low:.3g} to {high:.3g}{data.suffix}, not {sigma:g}")


def check_resolved(where: str, noise: NoiseLevel, rss: float, n: int, order: int) -> None:
    """Refuse deviations so far below the residuals that rounding hides the likelihood.

    Parameters
    ----------
    where : str
        The data and their axis, for the message.
    rss : float
        Weighted sum of squares of the highest order, of `n` points.

    Raises
    ------
    InputError
        Where chi-squared of the highest order is above 1e12.
    """
    if noise.value is not None and rss / noise.value**2 > LARGEST_CHI2:
        times = math.sqrt(rss / n) / noise.value
        raise InputError(
            f"{where}: the known deviations are {times:.0e} times smaller "
            f"than the residuals of order {order}: no double tells such likelihoods apart; "
            "check their unit"
        )


def prior_rule(data: AxisData, settings: Settings, stated: StatedPrior | None) -> PriorRule:
    """Choose the prior of an axis: as asked, else as the setup states, else field."""
    default = "stated" if stated is not None and settings.tau is None else "field"
    centre = data.size / 2 if data.size_known else data.middle
    name = settings.prior or default
    return PriorRule(name, data.size, centre, settings.tau, stated, data.pixel)
