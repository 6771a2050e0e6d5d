"""A calibrated camera of a result: the plausible models' draws, without the points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.pose import rotation_vectors
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.key import Key
from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.density.drawn import LinearFamily
from bayescal.density.pinholes.pinhole import PinholeModel
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials import bivariate, separable
from bayescal.polynomials.basis import Domain
from bayescal.prediction.calibrated.camera import CalibratedCamera, normalised
from bayescal.prediction.calibrated.draws import (
    AxisDraws,
    completed,
    joined,
    joined_estimates,
    mapped,
    new_noise,
    of_exact,
    of_posterior,
)
from bayescal.prediction.calibrated.hull import hull_of
from bayescal.prediction.calibrated.lens_member import LensMember
from bayescal.prediction.calibrated.members import Estimate, Member, Parameters
from bayescal.prediction.calibrated.polynomial_member import PolynomialMember

MOST = 12  # models kept of a pair of undecided axes


def camera_of(result: Any) -> CalibratedCamera:
    """Make the camera of a comparison of orders, of families, or of lens models.

    Raises
    ------
    InputError
        Where the result is of no camera: of arrays, or of one axis alone.
    """
    if isinstance(result, Comparison):
        return _of_orders(result)
    if isinstance(result, FamilyComparison):
        return _of_families(result)
    if type(result).__name__ == "LensComparison":  # families do not pay for many views
        from bayescal.prediction.calibrated.lenses import lens_camera

        return lens_camera(result)
    raise InputError(
        f"a result of the kind {type(result).__name__} holds no calibrated camera; take one of "
        "compare, fit or calibrate"
    )


def _of_orders(result: Comparison) -> CalibratedCamera:
    points = result.points
    if points is None:
        raise InputError("a polynomial of arrays is no camera: it has no points of the world")
    if set(result.axes) != set(AXES):
        missing = "c" if "r" in result.axes else "r"
        raise InputError(
            f"the comparison is of one axis alone; a camera needs {missing} too: leave out --axis"
        )
    axes = tuple(result.axes[name] for name in AXES)
    shares = [_shares(axis) for axis in axes]
    draws = [
        {k: of_posterior(axis[k].posterior, axis.data.sd) for k in share}
        for axis, share in zip(axes, shares, strict=True)
    ]
    pairs = sorted(
        ((p * q, k, m) for k, p in shares[0].items() for m, q in shares[1].items()),
        key=lambda pair: (-pair[0], pair[1:]),
    )[:MOST]
    members = [
        _polynomial(Key(separable.NAME, (k, m)), points, (draws[0][k], draws[1][m]))
        for _, k, m in pairs
    ]
    decided = all(axis.verdict.decided or axis.verdict.order is None for axis in axes)
    weights = [pair[0] for pair in pairs]
    return _camera(points, members, weights, sum(weights), not decided, result.notes)


def _shares(axis: AxisComparison) -> dict[int, float]:
    """Probability of each plausible order; of a flat prior, the chosen one alone."""
    if axis.verdict.order is None:
        return {axis.chosen.order: 1.0}
    return {k: axis[k].probability or 0.0 for k in axis.verdict.plausible}


def _of_families(result: FamilyComparison) -> CalibratedCamera:
    chances = {m.key: p for m, p in zip(result.models, result.probabilities, strict=True)}
    plausible = [m for m in result.models if m.key in result.verdict.plausible]
    members = [_member(result, model) for model in plausible]
    kept = [(m, chances[j.key]) for m, j in zip(members, plausible, strict=True) if m is not None]
    if not kept:
        raise InputError("none of the plausible models has draws to predict with")
    left = [str(j.key) for m, j in zip(members, plausible, strict=True) if m is None]
    notes = (f"without draws, left out: {'; '.join(left)}",) if left else ()
    weights = [p for _, p in kept]
    averaged = not result.verdict.decided
    models = [m for m, _ in kept]
    return _camera(result.points, models, weights, sum(weights), averaged, (*result.notes, *notes))


def _camera(
    points: Correspondences,
    members: Sequence[Member],
    weights: Sequence[float],
    covered: float,
    averaged: bool,
    notes: tuple[str, ...],
) -> CalibratedCamera:
    setup = points.setup
    size = None
    if setup.width is not None and setup.height is not None:
        size = (setup.width, setup.height)
    away = points.camera_frame()
    return CalibratedCamera(
        tuple(members),
        normalised(weights),
        covered,
        averaged and len(members) > 1,
        size,
        setup.c_from_bottom,
        hull_of(points.pixels),
        float(np.median(np.linalg.norm(away, axis=1))),
        points.source,
        notes,
    )


def _member(result: FamilyComparison, found: JointModel) -> Member | None:
    """Make a member of a joint model; None where neither closed form nor draws were kept."""
    points, key = result.points, found.key
    if found.exact:
        from bayescal.comparison.families.models import linear_axes

        rng, highest = key.rng(result.settings.seed, 1_000_000), max(result.request.orders)
        axes = linear_axes(points, separable.NAME, result.settings, highest)
        r, c = (of_exact(e, rng, a.data.sd) for e, a in zip(found.exact, axes, strict=True))
        return _polynomial(key, points, (r, c), name=str(key))
    kept = found.posterior or found.weighted
    if kept is None:
        return None
    full, model = completed(kept), kept.model
    if isinstance(model, PinholeModel):
        return _pinhole(str(key), points, model, full)
    assert isinstance(model, LinearFamily), "the other kind of joint model"
    r, c = map(AxisDraws.of, model.drawn(full))
    return _polynomial(key, points, (r, c), model.position(full), name=str(key))


def _polynomial(
    key: Key,
    points: Correspondences,
    axes: tuple[AxisDraws, AxisDraws],
    positions: Array | None = None,
    *,
    name: str = "",
) -> PolynomialMember:
    """Put both axes of a linear family together, with the camera position where it is inferred."""
    stated = points.camera_frame()
    ratios = stated[:, :2] / stated[:, 2:]
    first, second = (Domain.of(ratios[:, i]) for i in (0, 1))
    position: Array | None = np.array(points.setup.position)
    parameters = joined(axes[0].parameters, axes[1].parameters)
    if positions is not None:
        parameters = Parameters.of_draws(np.concatenate([parameters.draws, positions], axis=1))
        moved = points.world - positions.mean(axis=0)
        ratios, position = moved[:, :2] / moved[:, 2:], None
    scaled = np.column_stack([d.scale(ratios[:, i]) for i, d in enumerate((first, second))])
    level = np.column_stack([axis.log_sigma for axis in axes])
    eta = np.stack([axis.eta for axis in axes], axis=1)
    return PolynomialMember(
        (key.orders[0], key.orders[-1]),
        (first, second),
        key.family == bivariate.NAME,
        hull_of(scaled),
        position,
        float(np.sign(np.median(stated[:, 2]))),
        name or f"{key.family} ({key.order})",
        parameters,
        new_noise(level, eta, axes[0].noise, (axes[0].sd, axes[1].sd)),
        joined_estimates(*(axis.estimate for axis in axes)),
    )


def _pinhole(name: str, points: Correspondences, model: PinholeModel, full: Array) -> LensMember:
    """Take a pinhole's lens and pose from its draws."""
    geometry, theta = model.geometry, model.coordinates(full)
    matrices = geometry.rotation(theta)
    u, _, vt = np.linalg.svd(matrices.mean(axis=0))
    turn = u @ vt

    def coordinates(theta: Array) -> Array:
        turned = rotation_vectors(geometry.rotation(theta) @ turn.T)
        parts = [theta[:, :4], geometry.coefficients(theta), turned, theta[:, 7:9], -theta[:, 9:10]]
        return np.concatenate(parts, axis=1)

    level = np.column_stack([log_sigma for log_sigma, _ in model.levels(full)])
    eta = np.stack([eta for _, eta in model.levels(full)], axis=1)
    options = {
        "order": geometry.order,
        "tangential": False,
        "step": 2 if geometry.radial == "even" else 1,
    }
    member = LensMember(
        name,
        "radial",
        options,
        turn,
        np.array(geometry.centroid),
        np.empty((0, 2)),
        Parameters.of_draws(coordinates(theta)),
        new_noise(level, eta, model.noise, model.data.sd),
        _pinhole_estimate(model, lambda free: coordinates(geometry.full(free))),
    )
    # Of the predicted pixels: measured ones at the edge may lie inside by their noise.
    pixels, _ = member.project(member.parameters.mean[None], points.world)
    return replace(member, hull=hull_of(pixels[0]))


def _pinhole_estimate(
    model: PinholeModel, coordinates: Callable[[Array], Array]
) -> Estimate | None:
    """Maximum likelihood under Gaussian noise; of robust noise it is none."""
    if not model.noise.conjugate:
        return None
    fit, values = model.fit, 2 * model.data.n
    inferred = any(level.value is None for level in model.data.levels)
    dof = values - len(fit.free) if inferred else np.inf
    # A level that is inferred is fitted to residuals that the parameters made smaller.
    wider = values / dof if inferred else 1.0
    spread, vectors = np.linalg.eigh(wider * fit.covariance)
    root = vectors * np.sqrt(np.maximum(spread, 0.0))
    return mapped(Estimate(fit.free, root, ((len(fit.free), dof),)), coordinates)
