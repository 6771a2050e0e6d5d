"""Results of comparing lens models, frozen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.calibration.fitting.least_squares import Fit
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.judge import LensEvidence, Setting
from bayescal.calibration.model.error_model import ErrorModel
from bayescal.calibration.model.lens_model import LensModel
from bayescal.comparison.faces import convert
from bayescal.comparison.faces.face import Lists
from bayescal.comparison.faces.frames import lenses_frame
from bayescal.comparison.judged import Judged
from bayescal.comparison.lenses.bad.mixture import Mixed
from bayescal.comparison.lenses.bad.points import Bad
from bayescal.comparison.lenses.candidates import Candidate, LensKey
from bayescal.comparison.lenses.left_out import Split
from bayescal.comparison.lenses.off_point import GrossError
from bayescal.comparison.lenses.place import Place
from bayescal.comparison.lenses.prediction import View
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.verdict import LensVerdict
from bayescal.comparison.settings import Settings
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.markup import bullets, table
from bayescal.points.views.views import Views
from bayescal.rounding import significant

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, kw_only=True)
class JudgedLens(Judged, convert.Converts):
    """One lens model beside the others.

    Attributes
    ----------
    model : LensModel
        Without bow.
    fit : Fit
        Least squares under independent noise, the target taken as it is.
    rms : float
        Root mean square distance of points from it, px.
    n_parameters : int
        Lens, six for each view, sigma where inferred.
    chi2 : float or None
        Where sigma is known.
    aic, bic : float
        Of that fit, poses counted.
    loo : LeaveOneOut or None
        A unit is a view, its pose integrated, all else fitted to the others; None where the lens
        is too improbable to be looked at, or there are too few views.
    without : Array or None
        Coordinates of the lens without each view, ``(n_views, dimension)``.
    difference : float or None
        Largest distance of predictions from the best model's over the image, at infinity, after
        the turn of the poses is taken out, px; None where the models can't be compared.
    inside : float or None
        The same where the observed points are (their convex hull).
    difference_at_most, inside_at_most : float or None
        What these are at most with 95 % probability; None also of lenses that are excluded.
    mixed : Mixed or None
        Sets of bad points over which `log_evidence` is summed, where there may be such.
    """

    key: LensKey
    candidate: Candidate
    model: LensModel
    fit: Fit
    rms: float
    n_parameters: int
    chi2: float | None
    aic: float
    bic: float
    evidence: LensEvidence
    log_evidence: float
    log_evidence_error: float
    probability: float = 0.0
    without: Array | None = None
    difference: float | None = None
    inside: float | None = None
    difference_at_most: float | None = None
    inside_at_most: float | None = None
    mixed: Mixed | None = None

    @property
    def name(self) -> str:
        """As tables show it."""
        return self.candidate.name

    def named_covariance(self) -> tuple[tuple[str, ...], Array]:
        """By linear algebra about its mode, under its most probable error model."""
        problem = self.evidence.problem
        model, x, diagonal = problem.model, problem.x, problem.data.diagonal
        with threadpool_limits(1):  # the same on any number of cores
            own = problem.laplace.covariance
            steps = np.diag(np.sqrt(own.diagonal()))
            moved = model.report(x + steps, diagonal) - model.report(x - steps, diagonal)
            slopes = (moved / (2 * steps.diagonal()[:, None])).T
            return model.names, slopes @ own @ slopes.T

    def held(self) -> convert.Held:
        """Give no draws: only the most probable lens of a comparison has them."""
        return convert.Held(None, self.evidence.problem.model.names, None, {})

    @property
    def summaries(self) -> Sequence[Any]:
        """By linear algebra, as the covariance."""
        problem, (names, matrix) = self.evidence.problem, self.named_covariance()
        values = problem.model.report(problem.x, problem.data.diagonal)
        return convert.normal_moments(names, values, np.sqrt(matrix.diagonal()))

    @cached_property
    def view(self) -> View:
        """The lens at its mode, as predictions are made with it."""
        return View(self.evidence.problem.model, self.evidence.problem.x)


@dataclass(frozen=True, eq=False)
class Drawn:
    """What is drawn of the best lens.

    Attributes
    ----------
    posterior : SampledPosterior
        Under its most probable error model, by emcee.
    draws : Array
        Coordinates of the lens with the error models averaged, ``(n_draws, dimension)``.
    covariance : Array
        Of the same, by linear algebra, ``(dimension, dimension)``.
    halves : tuple of Split
        The lens fitted to every second view and to the others, and to the views up to the middle
        and after it; empty where there are too few.
    """

    posterior: SampledPosterior
    draws: Array
    covariance: Array
    halves: tuple[Split, ...]


@dataclass(frozen=True, eq=False)
class Evidenced:
    """What verdict and findings are made from.

    Attributes
    ----------
    setting : Setting
        Observations, error models, what is known of sigma.
    lenses : tuple of JudgedLens
        The most probable first.
    impossible : tuple of str
        Lenses that can't see some point of these views.
    failures : tuple of str
        Lenses whose fit stayed worse than that of one they contain.
    gross : tuple of GrossError
        Points further off than the errors allow, the least probable first; of those that are
        not taken for bad.
    bad : Bad or None
        Points taken for bad, and others that may be; None where all are taken as good.
    """

    views: Views
    setting: Setting
    lenses: tuple[JudgedLens, ...]
    impossible: tuple[str, ...]
    failures: tuple[str, ...]
    drawn: Drawn
    places: tuple[Place, ...]
    gross: tuple[GrossError, ...]
    bad: Bad | None

    @property
    def best(self) -> JudgedLens:
        """The most probable lens."""
        return self.lenses[0]

    @property
    def problem(self) -> Problem:
        """The best lens at its mode."""
        return self.best.evidence.problem

    @property
    def posterior(self) -> SampledPosterior:
        """Of the best lens under its most probable error model, by emcee."""
        return self.drawn.posterior

    @property
    def draws(self) -> Array:
        """Coordinates of the best lens with the error models averaged."""
        return self.drawn.draws

    @property
    def errors(self) -> tuple[tuple[ErrorModel, float], ...]:
        """Error models and their probabilities under the best lens."""
        found = self.best.evidence.errors
        models = map(self.setting.grid.error, found.nodes)
        return tuple(zip(models, found.weights, strict=True))

    @property
    def range(self) -> float:
        """Distance of the target from the camera, median over the views, the target's unit."""
        return self.problem.poses.depth * self.setting.data.diagonal


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class LensComparison(Evidenced, convert.Converts, Lists[str, JudgedLens]):
    """Lens models compared over many views of a target.

    Attributes
    ----------
    notes : tuple of str
        What was assumed.
    origin : dict or None
        As of `bayescal.comparison.results.Comparison`.
    derived : dict of str to Any
        What took long, by name (`bayescal.comparison.store.Store.once`).
    """

    verdict: LensVerdict
    notes: tuple[str, ...]
    request: LensRequest
    settings: Settings
    origin: dict[str, Any] | None = None
    derived: dict[str, Any] = field(default_factory=dict)

    @property
    def plausible(self) -> tuple[JudgedLens, ...]:
        """Lenses that can't be excluded at 95 %."""
        return tuple(j for j in self.lenses if j.name in self.verdict.plausible)

    @property
    def sound(self) -> bool:
        """Whether draws converged and evidences can be trusted, as far as they matter."""
        return self.posterior.converged and all(j.sound for j in self.plausible)

    absent = "{0!r} was not compared; compared: {1}"

    def named(self) -> list[tuple[str, JudgedLens]]:
        """List the lenses."""
        return [(judged.name, judged) for judged in self.lenses]

    def to_dataframe(self) -> pd.DataFrame:
        """Lenses in a data frame of pandas, a row each, the most probable first."""
        return lenses_frame(self)

    @property
    def summaries(self) -> Sequence[Any]:
        """Of the draws of the best lens."""
        return self.posterior.parameters

    def held(self) -> convert.Held:
        """Give draws of the best lens; a view's density needs its pose integrated out."""
        return convert.Held(self.posterior.chain.draws, self.posterior.names, None, {})

    def _repr_html_(self) -> str:
        """Show the lenses in a notebook."""
        heads = ["lens", "RMS [px]", "ln Z", "probability", "differs inside [px]"]
        rows = [
            [
                j.name,
                f"{j.rms:.4f}",
                f"{j.log_evidence:.2f}",
                f"{j.probability:.3f}",
                "" if j.inside is None else significant(j.inside),
            ]
            for j in self.lenses
        ]
        caption = f"{len(self.views)} views; {self.verdict.text}"
        shown = table(caption, heads, rows, marked=0)
        bad = [] if self.bad is None else [p.words for p in self.bad.points]
        return shown + bullets("Bad points", bad) + bullets("Caveats", self.verdict.caveats)

    def __repr__(self) -> str:
        lines = [f"<LensComparison: {len(self.lenses)} lenses over {len(self.views)} views"]
        lines += [f"  {j.name}: P {j.probability:.3f}, RMS {j.rms:.3f} px" for j in self.lenses[:5]]
        return "\n".join([*lines, f"  {self.verdict.text}>"])
