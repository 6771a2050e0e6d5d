"""The camera of many views: plausible lenses without a pose, their error models averaged."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.judging.averaging import ErrorAverage
from bayescal.calibration.judging.laplace import UNTOLD, degrees
from bayescal.calibration.model.lens_model import LensModel
from bayescal.comparison.lenses.candidates import Candidate
from bayescal.comparison.lenses.results import JudgedLens, LensComparison
from bayescal.prediction.calibrated.camera import CalibratedCamera, normalised
from bayescal.prediction.calibrated.draws import mapped, thinned
from bayescal.prediction.calibrated.hull import hull_of
from bayescal.prediction.calibrated.lens_member import LensMember
from bayescal.prediction.calibrated.members import KEPT, Estimate, Parameters
from bayescal.prediction.calibrated.noise import NewNoise

ALIGNED = 100  # calibration pixels that fix the frame
DETERMINED = 1e-10  # of the best determined direction: less is rounding
SLIGHT = 0.01  # of the most probable error model's share: those below it are left out
MOST = 4  # lenses kept of the plausible ones: each is drawn anew


def lens_camera(found: LensComparison) -> CalibratedCamera:
    """Make the camera of a comparison of lens models."""
    plausible = [j for j in found.lenses if j.name in found.verdict.plausible][:MOST]
    children = np.random.default_rng([found.settings.seed, 2]).spawn(len(plausible))
    data, views = found.setting.data, found.views
    pixels = data.pixels[data.seen]
    hull, seen = hull_of(pixels), thinned(pixels, ALIGNED)
    members: list[LensMember] = []
    for judged, rng in zip(plausible, children, strict=True):
        theta = _lens_draws(found, judged, rng)
        noise = _noise(found, judged, rng)
        made = lens_member(judged.candidate, theta, hull, noise, seen, members[:1])
        members.append(replace(made, estimate=_estimate(found, judged)))
    weights = [judged.probability for judged in plausible]
    return CalibratedCamera(
        tuple(members),
        normalised(weights),
        sum(weights),
        not found.verdict.decided and len(members) > 1,
        data.size,
        False,
        hull,
        found.range,
        views.source,
        found.notes,
    )


def lens_member(
    lens: Candidate,
    theta: Array,
    hull: Array,
    noise: NewNoise,
    seen: Array,
    reference: Sequence[LensMember] = (),
) -> LensMember:
    """Make a lens without a place in the world from its draws, each turned as the poses allow.

    Parameters
    ----------
    lens : Candidate
        Which, as it was compared.
    theta : Array
        ln fx, ln fy, cx, cy, coefficients, ``(n_draws, d)``.
    hull : Array
        Of the calibration pixels, px.
    seen : Array
        Some of the calibration pixels, ``(n, 2)``, px: what the poses hold to.
    reference : sequence of LensMember
        One whose mean's frame is taken; none for the lens's own.
    """
    parameters = Parameters.of_draws(theta)
    plain = LensMember(lens.name, lens.lens_name, lens.options, None, None, hull, parameters, noise)
    base = reference[0] if reference else plain
    sight = base.rays(base.parameters.mean[None], seen[None], None)
    known = sight.found[0]
    return plain.aligned(sight.direction[0, known], seen[known])


def _lens_draws(found: LensComparison, judged: JudgedLens, rng: np.random.Generator) -> Array:
    """Draws of a lens as a member has them, ``(KEPT, d)``."""
    best = judged.name == found.best.name
    draws = found.draws if best else ErrorAverage(judged.evidence, found.setting).draws(rng, KEPT)
    return _coordinates(judged.evidence.problem.model, thinned(draws))


def _coordinates(model: LensModel, x: Array) -> Array:
    """Parameters as a member has them, ``(m, d)``."""
    intrinsics, k, _ = model.physical(x)
    return np.concatenate([np.log(intrinsics[:, :2]), intrinsics[:, 2:], k], axis=1)


def _estimate(found: LensComparison, judged: JudgedLens) -> Estimate:
    """Least squares under each error model by its probability, poses eliminated."""
    setting, errors, best = found.setting, judged.evidence.errors, judged.evidence.problem
    shares = np.array(errors.weights)
    kept = np.flatnonzero(shares > SLIGHT * shares[0])
    shares = shares[kept] / shares[kept].sum()
    steps, roots, nu = [], [], degrees(setting.data)
    for i in kept:
        reduced = setting.under(best, errors.nodes[i]).reduced
        unit = 1 / np.sqrt(np.maximum(np.diag(reduced.precision), UNTOLD))
        values, vectors = np.linalg.eigh(reduced.precision * unit[:, None] * unit)
        use = values > DETERMINED * values[-1]
        basis = unit[:, None] * vectors[:, use] / np.sqrt(values[use])
        told = basis.T @ reduced.slope
        variance = (reduced.sum_of_squares - told @ told) / (nu - len(told))
        if setting.level.sigma is not None:
            variance = setting.level.sigma**2
        steps.append(basis @ told)
        roots.append(np.sqrt(variance) * basis)
    mean = shares @ np.array(steps)
    apart = np.array(steps) - mean
    rows = [np.sqrt(p) * part.T for p, part in zip(shares, roots, strict=True)]
    triangle = np.linalg.qr(np.concatenate([*rows, np.sqrt(shares)[:, None] * apart]), mode="r")
    dof = np.inf if setting.level.sigma is not None else nu - len(mean)
    own = Estimate(best.x + mean, triangle.T, ((len(triangle), dof),))
    return mapped(own, partial(_coordinates, best.model))


def _noise(found: LensComparison, judged: JudgedLens, rng: np.random.Generator) -> NewNoise:
    """Noise in a new view, with all that an error model has in it, the models averaged.

    A view is as loud as one of those of the calibration; the target's own errors count as each
    point's own.
    """
    setting, errors, best = found.setting, judged.evidence.errors, judged.evidence.problem
    shares = np.array(errors.weights)
    picked = rng.choice(len(shares), KEPT, p=shares / shares.sum())
    level = np.empty((KEPT, 3))  # own, shared, px; length, the target's unit
    for i in np.unique(picked):
        error, rows = setting.grid.error(errors.nodes[i]), np.flatnonzero(picked == i)
        sigma = np.full(len(rows), setting.level.sigma, dtype=np.float64)
        if setting.level.sigma is None:
            reduced = setting.problem(best.model, best.x, best.poses, errors.nodes[i]).reduced
            drawn = rng.chisquare(degrees(setting.data), len(rows))
            sigma = np.sqrt(reduced.sum_of_squares / drawn)
        if setting.data.levels is not None:
            sigma = sigma * rng.choice(setting.data.levels, len(rows))
        level[rows, 0] = sigma * math.sqrt(1 + error.rough**2 + error.smooth**2)
        level[rows, 1] = sigma * math.sqrt(error.correlated)
        level[rows, 2] = error.length * setting.data.diagonal
    total = np.log(np.hypot(level[:, 0], level[:, 1]))
    both, none = np.column_stack([total, total]), np.empty((KEPT, 2, 0))
    return NewNoise(both, none, neighbours=level if level[:, 1].any() else None)
