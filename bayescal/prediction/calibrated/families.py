"""The camera of a comparison across families: the plausible models that have draws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.pose import rotation_vectors
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.density.drawn import LinearFamily
from bayescal.density.pinholes.pinhole import PinholeModel
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials import separable
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.draws import AxisDraws, completed, mapped, new_noise, of_exact
from bayescal.prediction.calibrated.hull import hull_of
from bayescal.prediction.calibrated.lens_member import LensMember
from bayescal.prediction.calibrated.members import Estimate, Member, Parameters
from bayescal.prediction.calibrated.orders import points_camera, polynomial_member


def families_camera(result: FamilyComparison) -> CalibratedCamera:
    """Make the camera of a comparison across families.

    Raises
    ------
    InputError
        Where no plausible model has draws.
    """
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
    return points_camera(
        result.points, models, weights, sum(weights), averaged, (*result.notes, *notes)
    )


def _member(result: FamilyComparison, found: JointModel) -> Member | None:
    """Make a member of a joint model; None where neither closed form nor draws were kept."""
    points, key = result.points, found.key
    if found.exact:
        from bayescal.comparison.families.models import linear_axes

        rng, highest = key.rng(result.settings.seed, 1_000_000), max(result.request.orders)
        axes = linear_axes(points, separable.NAME, result.settings, highest)
        r, c = (of_exact(e, rng, a.data.sd) for e, a in zip(found.exact, axes, strict=True))
        return polynomial_member(key, points, (r, c), name=str(key))
    kept = found.posterior or found.weighted
    if kept is None:
        return None
    full, model = completed(kept), kept.model
    if isinstance(model, PinholeModel):
        return _pinhole(str(key), points, model, full)
    assert isinstance(model, LinearFamily), "the other kind of joint model"
    r, c = map(AxisDraws.of, model.drawn(full))
    return polynomial_member(key, points, (r, c), model.position(full), name=str(key))


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
