r"""Where points appear: the mapping's mean and deviation, and those of a new measurement.

Of each model f(theta, X): where f is linear in theta (polynomials at an exact position) the mean
f(mean) and the deviation |J root| are exact, whatever the coefficients' distribution is. Elsewhere
few points are averaged over the draws, block by block; many are propagated by one-sd steps along
the columns of the root of the covariance (central differences, with the second-order shift of the
mean), and some of them are done by draws too, so that the difference can be told.

Averaged over models of probabilities p_m, mean = sum p_m mean_m, and the variance of the mapping
is sum p_m var_m within the models plus sum p_m (mean_m - mean)^2 between them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, ArrayLike
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import Member, Moments
from bayescal.prediction.calibrated.noise import mixture_quantiles
from bayescal.prediction.given import checked

BLOCK = 400_000  # pixel values held at once
BY_DRAWS = 4_000_000  # draws times points that are averaged one by one
CHECKED = 200  # points that are propagated both ways
NOTICEABLE = 0.05  # relative difference of the two: the second digit of a deviation
PROBABILITY = 0.95
FRAME = (
    "Points are in the camera's frame as its mean lens has it; the turn that the poses of the "
    "views absorb is no part of sd."
)


@dataclass(frozen=True, eq=False)
class Prediction:
    """Predicted pixels; rows of points that are not seen are nan.

    Attributes
    ----------
    mean : Array
        r, c as recorded, ``(n, 2)``, px.
    sd : Array
        Of the mapping (epistemic), models averaged where the camera is, ``(n, 2)``, px.
    between : Array
        The part of it that is between the models, ``(n, 2)``, px.
    new_sd : Array
        Of a new measurement: mapping and noise, ``(n, 2)``, px. Of robust noise, whose sd may not
        exist, half of its central 68.3 % stands for the noise's.
    lower, upper : Array
        Ends of the central interval of a new measurement, ``(n, 2)``, px.
    probability : float
        Of that interval.
    seen : ndarray of bool
        Whether the chosen model sees the point, ``(n,)``.
    outside : ndarray of bool
        Whether it appears outside the image, ``(n,)``.
    extrapolated : ndarray of bool
        Whether it lies beyond what a model was calibrated with, ``(n,)``.
    method : str
        How means and deviations were computed, in words.
    notes : tuple of str
        Where the method falls short.
    """

    mean: Array
    sd: Array
    between: Array
    new_sd: Array
    lower: Array
    upper: Array
    probability: float
    seen: NDArray[np.bool_]
    outside: NDArray[np.bool_]
    extrapolated: NDArray[np.bool_]
    method: str
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.mean)

    def __repr__(self) -> str:
        seen = int(self.seen.sum())
        return f"<Prediction of {len(self)} points, {seen} seen; {self.method}>"


def predict(
    camera: CalibratedCamera, world: ArrayLike, *, average: bool | None = None
) -> Prediction:
    """Predict pixels of world points; parameters and errors as of `bayescal.predict`."""
    points = checked(world, 3, "world")
    camera = camera.average(average)
    members, weights = camera.used
    found = [moments(member, points) for member in members]
    notes = tuple(dict.fromkeys(note for m in members for note in _checked_by_draws(m, points)))
    notes = notes if camera.posed else (*notes, FRAME)
    mean, within, between = averaged(found, weights)
    lower, upper, new_sd = _intervals(members, weights, found, within + between)
    seen = found[0].seen
    covered = np.all([m.covered(points) for m in members], axis=0)
    for array in (mean, within, between, lower, upper, new_sd):
        array[~seen] = np.nan
    pixels = camera.recorded(mean)
    if camera.c_from_bottom:
        ends = camera.recorded(lower), camera.recorded(upper)
        lower = np.column_stack([lower[:, 0], ends[1][:, 1]])
        upper = np.column_stack([upper[:, 0], ends[0][:, 1]])
    return Prediction(
        pixels,
        np.sqrt(within + between),
        np.sqrt(between),
        new_sd,
        lower,
        upper,
        PROBABILITY,
        seen,
        seen & camera.outside(pixels),
        seen & ~covered,
        _words(members, len(points)),
        notes,
    )


def moments(member: Member, world: Array) -> Moments:
    """Mean and deviation of one model's mapping."""
    if member.linear is not None:
        return _blocks(world, member.linear, 8)
    if _by_draws(member, len(world)):
        return _blocks(world, partial(_over_draws, member), len(member.parameters.draws))
    return _blocks(world, partial(_by_steps, member), len(member.parameters.steps))


def averaged(found: list[Moments], weights: tuple[float, ...]) -> tuple[Array, Array, Array]:
    """Mean, variance within and variance between the models, ``(n, 2)`` each."""
    mean, within = np.zeros_like(found[0].mean), np.zeros_like(found[0].mean)
    for one, w in zip(found, weights, strict=True):
        mean += w * one.mean
        within += w * one.sd**2
    between = np.zeros_like(mean)
    if len(found) > 1:
        for one, w in zip(found, weights, strict=True):
            between += w * (one.mean - mean) ** 2
    return mean, within, between


def _by_draws(member: Member, n: int) -> bool:
    return n * len(member.parameters.draws) <= BY_DRAWS


def _words(members: tuple[Member, ...], n: int) -> str:
    """Say how means and deviations of these models are computed."""
    how = {
        "exact moments of the coefficients"
        if m.linear and m.parameters.exact
        else "moments of the coefficients' draws"
        if m.linear
        else f"{len(m.parameters.draws)} draws"
        if _by_draws(m, n)
        else "one-sd steps of the parameters"
        for m in members
    }
    return "; ".join(sorted(how))


def _blocks(world: Array, how: Callable[[Array], Moments], width: int) -> Moments:
    """Do points block by block, `width` pixels of each held at once."""
    step = max(1, BLOCK // (2 * width))
    parts = [how(world[i : i + step]) for i in range(0, max(len(world), 1), step)]
    return Moments(
        np.concatenate([p.mean for p in parts]),
        np.concatenate([p.sd for p in parts]),
        np.concatenate([p.seen for p in parts]),
    )


def _over_draws(member: Member, world: Array) -> Moments:
    """Mean and deviation over the draws that see a point."""
    kept = member.parameters
    pixels, seen = member.project(kept.draws, world)
    _, at_mean = member.project(kept.mean[None], world)
    count = np.maximum(seen.sum(axis=0), 1)[:, None]
    mean = pixels.sum(axis=0) / count  # those not seen are 0
    square = (np.where(seen[..., None], pixels - mean, 0.0) ** 2).sum(axis=0)
    return Moments(mean, np.sqrt(square / np.maximum(count - 1, 1)), at_mean[0])


def _by_steps(member: Member, world: Array) -> Moments:
    """Propagate by one-sd steps along the columns of the covariance's root."""
    steps = member.parameters.steps
    pixels, seen = member.project(steps, world)
    d = (len(steps) - 1) // 2
    middle, up, down = pixels[0], pixels[1 : 1 + d], pixels[1 + d :]
    mean = middle + ((up + down) / 2 - middle).sum(axis=0)
    variance = (((up - down) / 2) ** 2).sum(axis=0)
    everywhere = seen.all(axis=0)
    mean = np.where(everywhere[:, None], mean, middle)
    return Moments(mean, np.sqrt(variance), seen[0])


def _checked_by_draws(member: Member, world: Array) -> list[str]:
    """Say where one-sd steps and draws differ noticeably."""
    if member.linear or _by_draws(member, len(world)):
        return []
    some = world[np.linspace(0, len(world) - 1, CHECKED).astype(np.intp)]
    steps, draws = _by_steps(member, some), _over_draws(member, some)
    both = steps.seen & draws.seen & (draws.sd > 0).all(axis=1)
    if not both.any():
        return []
    apart = float(np.abs(steps.sd[both] / draws.sd[both] - 1).max())
    if apart <= NOTICEABLE + 3 / np.sqrt(2 * len(member.parameters.draws)):
        return []
    return [
        f"{member.name}: deviations by one-sd steps differ from those by draws by up to "
        f"{100 * apart:.0f}% (at {CHECKED} of the points): predict fewer points at once for draws"
    ]


def _intervals(
    members: tuple[Member, ...], weights: tuple[float, ...], found: list[Moments], total: Array
) -> tuple[Array, Array, Array]:
    """Find the ends of the interval of a new measurement, and its sd, ``(n, 2)`` each."""
    noise = np.array([m.noise.scale for m in members])
    lower, upper = np.empty_like(total), np.empty_like(total)
    share = np.array(weights)
    for axis in (0, 1):
        shapes = np.stack([m.noise.distribution[axis] for m in members])
        centres = np.stack([one.mean[:, axis] for one in found])
        scales = np.stack(
            [np.hypot(one.sd[:, axis], s) for one, s in zip(found, noise[:, axis], strict=True)]
        )
        tail = (1 - PROBABILITY) / 2
        lower[:, axis] = mixture_quantiles(shapes, centres, scales, share, tail)
        upper[:, axis] = mixture_quantiles(shapes, centres, scales, share, 1 - tail)
    return lower, upper, np.sqrt(total + share @ noise**2)
