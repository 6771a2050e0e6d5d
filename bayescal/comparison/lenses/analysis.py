"""Lens models compared over many views, and what is made of them together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bayescal.calibration.averaging import averaged_draws, averaged_laplace
from bayescal.calibration.evidence import proposal
from bayescal.calibration.laplace import degrees
from bayescal.calibration.observations import Observations
from bayescal.calibration.sampled import SampledLens
from bayescal.comparison.evidence import probabilities
from bayescal.comparison.lenses.caveats import lens_caveats
from bayescal.comparison.lenses.left_out import halves, leave_views_out
from bayescal.comparison.lenses.places import places
from bayescal.comparison.lenses.prediction import (
    View,
    covered,
    difference,
    image_grid,
    largest,
    observed_sample,
)
from bayescal.comparison.lenses.results import Evidenced, JudgedLens, LensComparison, Request
from bayescal.comparison.lenses.sweep import Judge, Progress, image_size
from bayescal.comparison.lenses.verdict import judge_lenses
from bayescal.errors import InputError
from bayescal.inference.sampled_posterior import Guess, sample_model
from bayescal.points.views.notes import view_notes
from bayescal.points.views.views import Views

PROBABLE = 1e-3  # lenses less probable than this are not looked at view by view
MOST_LOOKED_AT = 6
FEWEST = 20  # effective importance draws of the best lens: with fewer nothing can be said


def compare_lenses(
    views: Views, request: Request, progress: Progress = lambda _: None
) -> LensComparison:
    """Compare lens models over many views.

    Parameters
    ----------
    views : Views
    request : Request
    progress : callable, optional
        Called with the key of each lens that is begun.

    Returns
    -------
    LensComparison

    Raises
    ------
    InputError
        Where no lens can be fitted, or an option can't be used.
    """
    size, notes = image_size(views)
    judge = Judge(views, size, request, progress)
    if degrees(judge.data) <= 12:
        raise InputError(
            f"{views.source}: {views.n_points} points in {len(views)} views leave nothing to "
            "judge a lens by; add views or points"
        )
    judge.sweep()
    setting = judge.setting()
    lenses = _ranked(judge.judged)
    estimate = lenses[0].evidence.estimate
    if estimate.effective_fraction * estimate.draws < FEWEST:
        raise InputError(
            f"{views.source}: these views hardly say what the lens is (are they all alike?); add "
            "views from other sides and distances"
        )
    progress("views left out")
    lenses = _looked_at(lenses, setting.data)
    best = lenses[0]
    problem = best.evidence.problem
    progress(f"draws of {best.key}")
    for_chains, for_draws = np.random.default_rng([request.seed, 1]).spawn(2)
    posterior = sample_model(
        SampledLens(problem), for_chains, request.ess, Guess(*proposal(problem)), request.draws
    )
    draws = averaged_draws(best.evidence, setting, for_draws, request.draws)
    spread = averaged_laplace(best.evidence, setting)
    two = halves(problem)
    distance = float(np.median(np.linalg.norm(problem.poses.translation, axis=1)))
    found_places = places(best, lenses, setting.data, spread, two, distance)
    basis = Evidenced(
        views, setting, lenses, tuple(judge.failures), posterior, found_places, two, size
    )
    caveats = lens_caveats(basis)
    errors = tuple(
        (setting.grid.error(node), weight)
        for node, weight in zip(
            best.evidence.errors.nodes, best.evidence.errors.weights, strict=True
        )
    )
    return LensComparison(
        views,
        setting,
        lenses,
        tuple(judge.impossible),
        errors,
        posterior,
        draws,
        found_places,
        distance * setting.data.diagonal,
        judge_lenses(lenses, caveats),
        (*view_notes(views), *notes),
        request,
    )


def _ranked(judged: dict[str, JudgedLens]) -> tuple[JudgedLens, ...]:
    order = sorted(judged.values(), key=lambda j: -j.evidence.log_evidence)
    chances = probabilities([j.evidence.log_evidence for j in order])
    return tuple(replace(j, probability=p) for j, p in zip(order, chances, strict=True))


def _looked_at(lenses: tuple[JudgedLens, ...], data: Observations) -> tuple[JudgedLens, ...]:
    """Leave views out of the probable lenses, and compare all predictions with the best's."""
    best = lenses[0].evidence.problem
    view = View(best.model, best.x)
    sample, grid = observed_sample(data), image_grid(data.size)
    within = covered(grid, data)
    out = []
    for rank, judged in enumerate(lenses):
        problem = judged.evidence.problem
        other = View(problem.model, problem.x)
        probable = rank < 2 or (judged.probability >= PROBABLE and rank < MOST_LOOKED_AT)
        apart = difference(view, other, grid, sample, None) if rank else np.zeros(grid.shape)
        out.append(
            replace(
                judged,
                left_out=leave_views_out(problem) if probable else None,
                difference=largest(apart),
                inside=largest(apart[within]),
            )
        )
    return tuple(out)
