"""A lens that is fitted and to be judged: the candidate of a comparison of lenses."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from bayescal.arrays import LOG_2PI, Array
from bayescal.calibration.fitting.least_squares import Fit, rms
from bayescal.calibration.fitting.stacking import Poses
from bayescal.calibration.judging.judge import LensEvidence, Setting, Weighed, lens_evidence
from bayescal.calibration.model.error_grid import Averaged
from bayescal.calibration.model.lens_model import LensModel
from bayescal.comparison.lenses.bad.mixture import Mixed, Mixing, mixed
from bayescal.comparison.lenses.candidates import Candidate, LensKey
from bayescal.comparison.lenses.results import JudgedLens
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store


@dataclass(frozen=True, eq=False)
class FittedLens:
    """A lens with its least-squares fit.

    Attributes
    ----------
    below : tuple of (Array, Poses)
        Modes of lenses that it contains, in its coordinates.
    like : Averaged or None
        Error models of the lens before that leaves the most similar residuals.
    draws : int
        Importance draws.
    highest : float
        Largest log evidence of the lenses before, bad points apart.
    mixing : Mixing or None
        What lenses share where points may be bad.
    tag : str
        Told to what is kept, where lenses are judged again.
    then : callable
        Called with what is judged: a sweep goes on by it.
    """

    candidate: Candidate
    model: LensModel
    fit: Fit
    below: tuple[tuple[Array, Poses], ...]
    setting: Setting
    like: Averaged | None
    draws: int
    highest: float
    mixing: Mixing | None
    tag: str
    then: Callable[[JudgedLens], None]

    @property
    def key(self) -> LensKey:
        """Which it is."""
        return LensKey(name=self.candidate.name)

    def judge(self, store: Store, settings: Settings) -> JudgedLens:
        """Weigh its evidence."""
        once, seed = store.once_of(self.key), settings.seed
        found = once(f"evidence{self.tag}", Weighed, partial(self._weighed, seed))
        evidence = LensEvidence.of(found, self.model, self.setting)
        judged = judged_lens(self.candidate, self.model, self.fit, self.setting, evidence)
        if self.mixing is not None:
            find = partial(self._mixed, evidence, self.mixing, seed)
            judged = with_bad(judged, once(f"bad points{self.tag}", Mixed, find))
        self.then(judged)
        return judged

    def _mixed(self, evidence: LensEvidence, mixing: Mixing, seed: int) -> Mixed:
        rng = self.key.rng(seed, 4)
        return mixed(self.model, self.fit, evidence, mixing, rng, self.draws)

    def _weighed(self, seed: int) -> Weighed:
        rng = self.key.rng(seed)
        begin = (self.fit.x, self.fit.poses), *self.below
        return lens_evidence(
            self.model, begin, self.setting, self.like, rng, self.draws, self.highest
        )


def with_bad(judged: JudgedLens, found: Mixed | None) -> JudgedLens:
    """Give a lens the evidence of the sets of bad points; of those about the common one anew."""
    if found is None:
        return judged
    if found.common:
        total = judged.evidence.log_evidence + found.sets.log_share
        return replace(judged, log_evidence=total, mixed=found)
    warnings, error = found.warnings, found.error
    return replace(
        judged, log_evidence=found.total, log_evidence_error=error, warnings=warnings, mixed=found
    )


def judged_lens(
    candidate: Candidate,
    model: LensModel,
    fit: Fit,
    setting: Setting,
    evidence: LensEvidence,
) -> JudgedLens:
    """Put a lens's evidence beside its least-squares criteria."""
    data, sigma = setting.data, setting.level.sigma
    n, k = data.n_points, model.dimension + 6 * data.n_views
    chi2 = None
    if sigma is not None:
        chi2 = fit.sum_of_squares / sigma**2
        log_likelihood = -0.5 * chi2 - 2 * n * math.log(sigma)
    else:
        k += 1
        log_likelihood = -n * (math.log(fit.sum_of_squares / (2 * n)) + 1)
    log_likelihood += data.log_weight - n * LOG_2PI
    aic, bic = (-2 * log_likelihood + k * each for each in (2, math.log(n)))
    return JudgedLens(
        key=LensKey(name=candidate.name),
        log_evidence=evidence.log_evidence,
        log_evidence_error=evidence.estimate.error,
        warnings=evidence.estimate.warnings,
        candidate=candidate,
        model=model,
        fit=fit,
        rms=rms(data, fit.sum_of_squares),
        n_parameters=k,
        chi2=chi2,
        aic=aic,
        bic=bic,
        evidence=evidence,
        loo=None,
    )
