"""The camera of many views: plausible lenses without a pose, their error models averaged."""

from __future__ import annotations

import math

import numpy as np

from bayescal.calibration.averaging import averaged_draws
from bayescal.calibration.laplace import degrees
from bayescal.comparison.lenses.results import JudgedLens, LensComparison
from bayescal.prediction.calibrated import CalibratedCamera, normalised
from bayescal.prediction.draws import KEPT, thinned
from bayescal.prediction.hull import hull_of
from bayescal.prediction.members import LensMember, Parameters
from bayescal.prediction.noise import NewNoise

MOST = 4  # lenses kept of the plausible ones: each is drawn anew


def lens_camera(found: LensComparison) -> CalibratedCamera:
    """Make the camera of a comparison of lens models."""
    plausible = [j for j in found.lenses if j.key in found.verdict.plausible][:MOST]
    children = np.random.default_rng([found.request.seed, 2]).spawn(len(plausible))
    members = tuple(
        _member(found, judged, rng) for judged, rng in zip(plausible, children, strict=True)
    )
    weights = [judged.probability for judged in plausible]
    views, (width, height) = found.views, found.setting.data.size
    return CalibratedCamera(
        members,
        normalised(weights),
        sum(weights),
        found.verdict.status != "decided" and len(members) > 1,
        (width, height),
        False,
        hull_of(views.pixels),
        found.range,
        views.source,
        found.notes,
    )


def _member(found: LensComparison, judged: JudgedLens, rng: np.random.Generator) -> LensMember:
    best = judged.key == found.best.key
    draws = found.draws if best else averaged_draws(judged.evidence, found.setting, rng, KEPT)
    model = judged.evidence.problem.model
    intrinsics, k, _ = model.physical(thinned(draws))
    theta = np.concatenate([np.log(intrinsics[:, :2]), intrinsics[:, 2:], k], axis=1)
    name, options = named(judged.key)
    return LensMember(
        judged.key,
        name,
        options,
        None,
        None,
        hull_of(found.views.pixels),
        Parameters.of_draws(theta),
        _noise(found, judged, rng),
    )


def _noise(found: LensComparison, judged: JudgedLens, rng: np.random.Generator) -> NewNoise:
    """Noise of a new measurement: that of the residuals, the target's errors in it."""
    data, known = found.setting.data, found.setting.level.sigma
    if known is not None:
        log_sigma = np.full(KEPT, math.log(known))
    else:
        dof = degrees(data)
        total = judged.rms**2 * data.n_points
        log_sigma = np.log(total / rng.chisquare(dof, KEPT)) / 2
    return NewNoise(np.column_stack([log_sigma, log_sigma]), np.empty((KEPT, 2, 0)))


def named(key: str) -> tuple[str, dict[str, int | bool]]:
    """Name and options of a lens as tables show it: "radial 2 + p", "fisheye 3", "eucm"."""
    if key == "pinhole":
        return "radial", {"order": 0, "tangential": False}
    words = key.split()
    if words[0] == "radial":
        return "radial", {"order": int(words[1]), "tangential": words[-1] == "p"}
    return words[0], {"order": int(words[1])} if len(words) > 1 else {}
