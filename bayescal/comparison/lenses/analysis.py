"""Lens models compared over many views, and what is made of them together."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.calibration.judging.averaging import ErrorAverage
from bayescal.calibration.judging.evidence import proposal
from bayescal.calibration.judging.judge import LensEvidence, Setting, Weighed, sought
from bayescal.calibration.judging.laplace import Level, degrees
from bayescal.calibration.judging.sampled import SampledLens
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.comparison.judged import with_probabilities
from bayescal.comparison.judging import judge_all
from bayescal.comparison.lenses.bad.points import Bad, bad_points
from bayescal.comparison.lenses.caveats.listed import lens_findings
from bayescal.comparison.lenses.fitted import judged_lens, with_bad
from bayescal.comparison.lenses.gross_errors import gross_errors
from bayescal.comparison.lenses.judging import judge_lenses, plausible_others
from bayescal.comparison.lenses.left_out import Split, halves, leave_views_out
from bayescal.comparison.lenses.off_point import GrossError
from bayescal.comparison.lenses.places import places
from bayescal.comparison.lenses.prediction import (
    at_most,
    covered,
    difference,
    distances_drawn,
    image_grid,
    largest,
    observed_sample,
)
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import Drawn, Evidenced, JudgedLens, LensComparison
from bayescal.comparison.lenses.sweep import Sweep, size_notes
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.errors import InputError
from bayescal.inference.sampled_posterior import Guess, SampledPosterior, sample_model
from bayescal.points.views.notes import view_notes
from bayescal.points.views.views import Views

PROBABLE = 1e-3  # lenses less probable than this are not looked at view by view
MOST_LOOKED_AT = 6
FEW = 0.1  # effective share of draws: a rival with fewer is weighed again
TURNS = 3  # of judging all lenses at most, until the points that are bad stay the same
REACH = 5.0  # nat: a lens that is further below the best is no rival

Progress = Callable[[str], None]


def compare_lenses(
    views: Views,
    request: LensRequest,
    settings: Settings,
    progress: Progress = lambda _: None,
    store: Store | None = None,
) -> LensComparison:
    """Compare lens models over many views.

    Parameters
    ----------
    settings : Settings
        Of which sigma, seed and ess are used.
    progress : callable, optional
        Called with the name of each lens that is begun.
    store : Store, optional
        What has already been judged and drawn.

    Returns
    -------
    LensComparison

    Raises
    ------
    InputError
        Where no lens can be fitted, or an option can't be used.
    """
    with threadpool_limits(1):  # matrices are small: threads of BLAS would only wait
        return _compared(views, request, settings, progress, store or Store())


def _compared(
    views: Views, request: LensRequest, settings: Settings, progress: Progress, store: Store
) -> LensComparison:
    sweep, lenses, unmet = weighed_lenses(views, request, settings, progress, store)
    setting = sweep.setting
    if not lenses:
        raise InputError(
            f"{views.source}: these views hardly say what the lens is (are they all alike?); add "
            "views from other sides and distances"
        )
    progress("views left out")
    lenses = _looked_at(lenses, store)
    progress(f"draws of {lenses[0].name}")
    drawn = _drawn(lenses[0], setting, request, settings, store)
    find = partial(gross_errors, lenses, setting, views)
    gross = store.once("gross errors", tuple[GrossError, ...], find)
    lenses = _apart(lenses, setting, drawn, settings.seed)
    found: dict[str, Any] = {
        "views": views, "setting": setting, "lenses": lenses, "drawn": drawn, "gross": gross,
        "bad": _bad(lenses, sweep, views),
        "places": places(lenses, setting.data, drawn.covariance, drawn.halves),
        "impossible": tuple(sweep.impossible),
        "failures": tuple(dict.fromkeys([*sweep.failures, *unmet])),
    }  # fmt: skip
    bad = found["bad"].words(views.n_points) if found["bad"] is not None else ""
    return LensComparison(
        **found,
        verdict=judge_lenses(lenses, lens_findings(Evidenced(**found)), bad),
        notes=(*view_notes(views), *size_notes(views)),
        request=request,
        settings=settings,
        derived=store.derived,
    )


def weighed_lenses(
    views: Views,
    request: LensRequest,
    settings: Settings,
    progress: Progress = lambda _: None,
    store: Store | None = None,
) -> tuple[Sweep, tuple[JudgedLens, ...], list[str]]:
    """Sweep through lenses; rank them, and name those that might win had they been found."""
    kept = Store() if store is None else store
    sweep, judged = _swept(views, request, settings, progress, kept)
    lenses, unmet = _parted(_sought(judged, sweep.setting, request, settings, kept, progress))
    return sweep, lenses, unmet


def _swept(
    views: Views, request: LensRequest, settings: Settings, progress: Progress, store: Store
) -> tuple[Sweep, tuple[JudgedLens, ...]]:
    """Judge all lenses; anew where other points are bad than was thought."""
    bad: tuple[int, ...] | None = None
    for turn in range(TURNS):
        tag = f" {turn + 1}" if turn else ""
        if request.mixture and not turn:
            progress("bad points")
        sweep = Sweep(views, request, level_of(settings), store.once, bad, tag)
        if degrees(sweep.data) <= 12:
            raise InputError(
                f"{views.source}: {views.n_points} points in {len(views)} views leave nothing to "
                "judge a lens by; add views or points"
            )
        judged = judge_all(sweep, store, settings, lambda key: progress(str(key)))
        if not judged:
            raise InputError("calibrate: no lens can see all points of these views")
        met = [j for j in judged if math.isfinite(j.log_evidence_error)] or judged
        best = max(met, key=lambda j: j.log_evidence)
        if best.mixed is None:
            break
        bad = tuple(np.flatnonzero(best.mixed.sets.likely).tolist())
        if bad == sweep.bad:
            break
    return sweep, judged


def _sought(
    judged: Sequence[JudgedLens],
    setting: Setting,
    request: LensRequest,
    settings: Settings,
    store: Store,
    progress: Progress,
) -> list[JudgedLens]:
    """Weigh rivals again of whose draws few were effective."""
    least = _best(judged) - REACH
    out = list(judged)
    for number, one in enumerate(judged):
        if one.evidence.estimate.effective_fraction > FEW or one.log_evidence < least:
            continue
        progress(f"{one.name} once more")
        rng = one.key.rng(settings.seed, 3)
        again = partial(sought, one.evidence, setting, rng, request.draws)
        found = store.once_of(one.key)("evidence sought", Weighed, again)
        if found.estimate.error >= one.log_evidence_error:
            continue
        evidence = LensEvidence.of(found, one.model, setting)
        weighed = judged_lens(one.candidate, one.model, one.fit, setting, evidence)
        out[number] = with_bad(weighed, one.mixed)
    return out


def _best(judged: Sequence[JudgedLens]) -> float:
    """Largest log evidence of those that were found."""
    found = (j.log_evidence for j in judged if math.isfinite(j.log_evidence_error))
    return max(found, default=-math.inf)


def _parted(judged: Sequence[JudgedLens]) -> tuple[tuple[JudgedLens, ...], list[str]]:
    """Rank lenses, and name those that might win had their posteriors been found."""
    least = _best(judged) - REACH
    unmet = [j for j in judged if math.isinf(j.log_evidence_error) and j.log_evidence > least]
    ranking = ranked(with_probabilities([j for j in judged if j not in unmet]))
    return ranking, [j.name for j in unmet]


def level_of(settings: Settings) -> Level:
    """Say what is known of sigma."""
    known = settings.sigma
    return Level(known if isinstance(known, float) else None)


def ranked(judged: Sequence[JudgedLens]) -> tuple[JudgedLens, ...]:
    """Sort lenses, the most probable first."""
    return tuple(sorted(judged, key=lambda j: -j.log_evidence))


def _looked_at(lenses: tuple[JudgedLens, ...], store: Store) -> tuple[JudgedLens, ...]:
    """Leave views out of the probable lenses."""
    out = list(lenses)
    for rank, judged in enumerate(lenses):
        if rank < 2 or (judged.probability >= PROBABLE and rank < MOST_LOOKED_AT):
            leave = partial(leave_views_out, judged.evidence.problem)
            kind = tuple[LeaveOneOut, Array] | None
            found = store.once_of(judged.key)("views left out", kind, leave)
            if found is not None:
                out[rank] = replace(judged, loo=found[0], without=found[1])
    return tuple(out)


def _bad(lenses: Sequence[JudgedLens], sweep: Sweep, views: Views) -> Bad | None:
    """Name the points that may be bad."""
    known = [(j.mixed.sets, j.probability) for j in lenses if j.mixed is not None]
    return bad_points(known, sweep.bad, views) if known else None


def _apart(
    lenses: tuple[JudgedLens, ...], setting: Setting, drawn: Drawn, seed: int
) -> tuple[JudgedLens, ...]:
    """Compare the predictions of all with the best's; of plausible ones with their uncertainty."""
    data, best = setting.data, lenses[0]
    sample, grid = observed_sample(data), image_grid(data.size)
    within, plausible = covered(grid, data), plausible_others(lenses)
    out = [replace(best, difference=0.0, inside=0.0)]
    for judged in lenses[1:]:
        apart = difference(best.view, judged.view, grid, sample, None)
        found = replace(judged, difference=largest(apart), inside=largest(apart[within]))
        if judged in plausible:
            # The draws of the larger lens know what the smaller one lacks.
            larger = judged.model.dimension > best.model.dimension
            one, other = (judged, best) if larger else (best, judged)
            own = judged.evidence.problem.laplace.covariance if larger else drawn.covariance
            rng = judged.key.rng(seed, 2)
            sizes = distances_drawn(one.view, other.view, own, grid, sample, rng)
            found = replace(
                found, difference_at_most=at_most(sizes), inside_at_most=at_most(sizes[:, within])
            )
        out.append(found)
    return tuple(out)


def _drawn(
    best: JudgedLens, setting: Setting, request: LensRequest, settings: Settings, store: Store
) -> Drawn:
    problem, key = best.evidence.problem, best.key
    for_chains, for_draws = key.rng(settings.seed, 1).spawn(2)
    model = SampledLens(best.evidence.density)

    def sample() -> SampledPosterior:
        mixture, modes = proposal(problem)
        guess = Guess(mixture, modes[:1])  # the others are of other strengths, not apart
        return sample_model(model, for_chains, settings.ess, guess, request.draws)

    def average() -> tuple[Array, Array, tuple[Split, ...]]:
        averaged = ErrorAverage(best.evidence, setting)
        draws = averaged.draws(for_draws, request.draws)
        return draws, averaged.covariance(), halves(problem)

    posterior = store.posterior(key, model, sample)
    kind = tuple[Array, Array, tuple[Split, ...]]
    return Drawn(posterior, *store.once_of(key)("errors averaged", kind, average))
