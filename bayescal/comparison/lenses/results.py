"""Results of comparing lens models, frozen."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bayescal.arrays import Array
from bayescal.calibration.density import Problem
from bayescal.calibration.error_model import ErrorModel
from bayescal.calibration.judge import LensEvidence, Setting
from bayescal.calibration.least_squares import Fit
from bayescal.calibration.lens_model import LensModel
from bayescal.comparison.lenses.candidates import Candidate
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.markup import bullets, table
from bayescal.points.views.views import Views
from bayescal.rounding import significant


@dataclass(frozen=True)
class Request:
    """What is asked for.

    Attributes
    ----------
    lenses : tuple of str or None
        As the user names them; None to have them found.
    sigma : float or None
        Known noise level, px; None where it is inferred.
    independent : bool
        Whether noise is taken as independent and the target as exact.
    square, centred : bool
        Whether fx = fy; whether the principal point stays in the middle.
    seed : int
    ess : int
        Effective samples wanted of every parameter.
    draws : int
        Importance draws of each lens.
    """

    lenses: tuple[str, ...] | None = None
    sigma: float | None = None
    independent: bool = False
    square: bool = False
    centred: bool = False
    seed: int = 0
    ess: int = 400
    draws: int = 2000


@dataclass(frozen=True, eq=False)
class ViewsLeftOut:
    """What views say that a lens has not seen: each left out in turn, the rest fitted again.

    Attributes
    ----------
    log_density : Array
        ln p(view | other views), its pose integrated, ``(n_views,)``, nat.
    lenses : Array
        Coordinates of the lens without each view, ``(n_views, dimension)``.
    """

    log_density: Array
    lenses: Array

    @property
    def elpd(self) -> float:
        """Sum over the views."""
        return float(self.log_density.sum())

    @property
    def se(self) -> float:
        """Standard error of that sum."""
        n = len(self.log_density)
        return float(self.log_density.std(ddof=1) * math.sqrt(n))


@dataclass(frozen=True, eq=False)
class JudgedLens:
    """One lens model beside the others.

    Attributes
    ----------
    candidate : Candidate
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
    evidence : LensEvidence
    probability : float
    left_out : ViewsLeftOut or None
        Where probable enough to be looked at, and there are views enough.
    difference : float or None
        Largest distance of predictions from the best model's over the image, at infinity, after
        the turn of the poses is taken out, px; None where the models can't be compared.
    inside : float or None
        The same where the observed points are (their convex hull).
    """

    candidate: Candidate
    model: LensModel
    fit: Fit
    rms: float
    n_parameters: int
    chi2: float | None
    aic: float
    bic: float
    evidence: LensEvidence
    probability: float = 0.0
    left_out: ViewsLeftOut | None = None
    difference: float | None = None
    inside: float | None = None

    @property
    def key(self) -> str:
        """As tables show it."""
        return self.candidate.key


@dataclass(frozen=True)
class Place:
    """Uncertainty of the projection at a place of the image, px.

    Attributes
    ----------
    name : str
    pixel : tuple of float
    infinity, near : float or None
        Standard deviation, root mean square of r and c, of a point at infinity and of one at the
        target's distance; None where the lens sees nothing there.
    jackknife, halves : float or None
        The same at infinity from the spread over views: each left out in turn, and the distance
        of the fits to two halves of the views over the square root of 2.
    """

    name: str
    pixel: tuple[float, float]
    infinity: float | None
    near: float | None
    jackknife: float | None
    halves: float | None


@dataclass(frozen=True, eq=False)
class Evidenced:
    """What caveats are made from.

    Attributes
    ----------
    views : Views
    setting : Setting
    lenses : tuple of JudgedLens
        The most probable first.
    failures : tuple of str
        Lenses whose fit stayed worse than that of one they contain.
    posterior : SampledPosterior
    places : tuple of Place
    two : tuple of Problem or None
    size : tuple of float
        Of the image, px.
    """

    views: Views
    setting: Setting
    lenses: tuple[JudgedLens, ...]
    failures: tuple[str, ...]
    posterior: SampledPosterior
    places: tuple[Place, ...]
    two: tuple[Problem, Problem] | None
    size: tuple[float, float]

    @property
    def problem(self) -> Problem:
        """The best lens at its mode."""
        return self.lenses[0].evidence.problem


@dataclass(frozen=True)
class LensVerdict:
    """What is recommended.

    Attributes
    ----------
    best : str
        Key of the most probable lens.
    plausible : tuple of str
        Smallest set of lenses, by falling probability, that reaches 95 %.
    status : str
        decided, suffices or undecided.
    worth, beyond : float or None
        Largest difference in prediction among the plausible ones, px: where the points are, and
        over the whole image.
    caveats : tuple of str
    text : str
    """

    best: str
    plausible: tuple[str, ...]
    status: str
    worth: float | None
    beyond: float | None
    caveats: tuple[str, ...]
    text: str


@dataclass(frozen=True, eq=False)
class LensComparison:
    """Lens models compared over many views of a target.

    Attributes
    ----------
    views : Views
    setting : Setting
        Observations, error models, what is known of sigma.
    lenses : tuple of JudgedLens
        The most probable first.
    impossible : tuple of str
        Lenses that can't see some point of these views.
    errors : tuple of (ErrorModel, float)
        Error models and their probabilities under the best lens.
    posterior : SampledPosterior
        Of the best lens under its most probable error model, by emcee.
    draws : Array
        Coordinates of the best lens with the error models averaged, ``(n_draws, dimension)``.
    places : tuple of Place
    range : float
        Distance of the target from the camera, median over the views, the target's unit.
    verdict : LensVerdict
    notes : tuple of str
        What was assumed.
    request : Request
    """

    views: Views
    setting: Setting
    lenses: tuple[JudgedLens, ...]
    impossible: tuple[str, ...]
    errors: tuple[tuple[ErrorModel, float], ...]
    posterior: SampledPosterior
    draws: Array
    places: tuple[Place, ...]
    range: float
    verdict: LensVerdict
    notes: tuple[str, ...]
    request: Request

    @property
    def best(self) -> JudgedLens:
        """The most probable lens."""
        return self.lenses[0]

    @property
    def sound(self) -> bool:
        """Whether draws converged and evidences can be trusted, as far as they matter."""
        plausible = [j for j in self.lenses if j.key in self.verdict.plausible]
        return self.posterior.converged and all(j.evidence.estimate.certain for j in plausible)

    def __getitem__(self, key: str) -> JudgedLens:
        for judged in self.lenses:
            if judged.key == key:
                return judged
        raise KeyError(key)

    def _repr_html_(self) -> str:
        """Show the lenses in a notebook."""
        heads = ["lens", "RMS [px]", "ln Z", "probability", "differs inside [px]"]
        rows = [
            [
                j.key,
                f"{j.rms:.4f}",
                f"{j.evidence.log_evidence:.2f}",
                f"{j.probability:.3f}",
                "" if j.inside is None else significant(j.inside),
            ]
            for j in self.lenses
        ]
        caption = f"{len(self.views)} views; {self.verdict.text}"
        shown = table(caption, heads, rows, marked=0)
        return shown + bullets("Caveats", self.verdict.caveats)

    def __repr__(self) -> str:
        lines = [f"<LensComparison: {len(self.lenses)} lenses over {len(self.views)} views"]
        lines += [f"  {j.key}: P {j.probability:.3f}, RMS {j.rms:.3f} px" for j in self.lenses[:5]]
        return "\n".join([*lines, f"  {self.verdict.text}>"])
