"""Models of the joint data, whatever their family, on one scale."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.conclusion import Verdict
from bayescal.comparison.convert import Converts, Held, models_frame, moments
from bayescal.comparison.judged import Judged
from bayescal.comparison.key import FREE, PINHOLE, STATED, Key
from bayescal.comparison.standing import DECIDED, standing_among
from bayescal.comparison.verdict import listed_words, percent
from bayescal.markup import bullets
from bayescal.points.correspondences import Correspondences

if TYPE_CHECKING:  # the hint in a comparison of orders samples nothing
    import pandas as pd

    from bayescal.cameras.pinhole import Radial
    from bayescal.comparison.adequacy.outcome import AdequacyTest
    from bayescal.comparison.criteria.goodness import GoodnessOfFit
    from bayescal.comparison.criteria.information import Criteria
    from bayescal.comparison.defence.stability import Removal
    from bayescal.comparison.settings import Settings
    from bayescal.density.pinholes.pinhole import PinholeModel
    from bayescal.inference.sampled_posterior import SampledPosterior
    from bayescal.inference.weighting import WeightedDraws
    from bayescal.linear.closed_form import ExactPosterior

NAMED = 4  # plausible models named beside the most probable one


@dataclass(frozen=True)
class FamilyRequest:
    """Which models of r and c are wanted.

    Attributes
    ----------
    families : tuple of str
        Of ``"separable"``, ``"bivariate"``, ``"pinhole"``.
    orders : tuple of int
        Polynomial degrees, ascending; every pair of them in the separable family.
    positions : tuple of str or None
        ``"stated"``, ``"free"`` or both; None: stated, and free for a pinhole, whose
        position is part of its pose.
    radial : str
        Powers of the radius in the pinhole's distortion, ``"even"`` or ``"all"``.
    radial_orders : tuple of int
        Numbers of radial coefficients of the pinhole.
    pairs : tuple of tuple of int, or None
        The only pairs of orders, of r and c, to take in the separable family.
    """

    families: tuple[str, ...]
    orders: tuple[int, ...]
    positions: tuple[str, ...] | None = None
    radial: Radial = "even"
    radial_orders: tuple[int, ...] = (0,)
    pairs: tuple[tuple[int, int], ...] | None = None

    def positions_of(self, family: str) -> tuple[str, ...]:
        """Treatments of the position wanted of a family."""
        default = FREE if family == PINHOLE else STATED
        return tuple(dict.fromkeys(self.positions or (default,)))


@dataclass(frozen=True, eq=False, kw_only=True)
class JointModel(Judged, Converts):
    """One joint model of r and c: what a candidate is judged by, and its likelihood.

    Attributes
    ----------
    criteria : Criteria
        K counts coefficients, inferred sigmas and the position where it is free; n counts points.
        There are no criteria of an exact fit, nor under robust noise, whose likelihood may have
        no maximum (a sigma that shrinks about a few points).
    goodness : GoodnessOfFit or None
        Chi-squared of both axes, where no sigma is inferred.
    position : Array
        Camera position of highest likelihood, of a linear family under robust noise of highest
        posterior density, ``(3,)``, world units.
    position_sd : Array
        Its standard errors that the points alone give; zero where none of the likelihood's is
        known.
    residuals : Array
        Measured less predicted, by least squares at that position, ``(2, n_points)``, px.
    camera : PinholeModel or None
        The density of a pinhole.
    exact : tuple of ExactPosterior
        Of r and of c, at the stated position of a linear family; empty elsewhere.
    posterior : SampledPosterior or None
        Of a model that was sampled: pinholes, a family's best at a free position, and under
        robust noise linear families at the stated one.
    weighted : WeightedDraws or None
        Of a model that has no closed form and was not sampled.
    pixels : Array or None
        Measured, ``(2, n_points)``, px.
    """

    log_evidence: float
    log_evidence_error: float
    criteria: Criteria
    position: Array
    residuals: Array
    position_sd: Array = field(default_factory=lambda: np.zeros(3))
    camera: PinholeModel | None = None
    goodness: GoodnessOfFit | None = None
    exact: tuple[ExactPosterior, ...] = ()
    posterior: SampledPosterior | None = None
    weighted: WeightedDraws | None = None
    pixels: Array | None = None

    @property
    def _parameters(self) -> Sequence[Any]:
        """Summaries of the draws, or of the closed forms of r and of c."""
        if self.posterior is not None:
            return self.posterior.parameters
        if self.weighted is not None:
            return moments(self.weighted.model.names, self.weighted.reported)
        from bayescal.comparison.families.exact_parameters import exact_parameters

        return exact_parameters(self.exact)

    def covariance(self) -> pd.DataFrame:
        """Posterior covariance in a data frame: of the draws, or of coefficients in closed form."""
        if not self.exact:
            return super().covariance()
        import pandas as pd

        from bayescal.comparison.families.exact_parameters import exact_covariance

        names, matrix = exact_covariance(self.exact)
        return pd.DataFrame(matrix, index=list(names), columns=list(names))

    def held(self) -> Held:
        """Give draws, densities and data."""
        pixels = self.pixels
        observed = {} if pixels is None else dict(zip(("r", "c"), pixels, strict=True))
        if self.posterior is not None:
            full, model = self.posterior.full, self.posterior.model
            draws, names = self.posterior.chain.draws, self.posterior.names
        elif self.weighted is not None:
            full, model = self.weighted.full[None], self.weighted.model
            draws, names = self.weighted.reported[None], model.names
        else:
            return Held(None, (), None, observed)

        def density() -> Array:
            values = model.log_likelihood(full.reshape(-1, full.shape[2]))
            return np.asarray(values.reshape(*full.shape[:2], -1))

        return Held(draws, names, density, observed)


@dataclass(frozen=True, eq=False)
class GroupedErrors:
    """Deviations of a model's parameters by the jackknife over groups of points.

    Attributes
    ----------
    source : str
        What makes a group: ``"column group"`` or ``"plane z"``.
    count : int
        Groups.
    sd : dict of str to float
        Of each parameter but those of the noise, in its unit.
    """

    source: str
    count: int
    sd: dict[str, float]


@dataclass(frozen=True, eq=False)
class FamilyDefence:
    """Answers to a referee, on models of r and c together.

    Attributes
    ----------
    points_that_matter, groups_that_matter : tuple of Removal
        Whose removal makes another model the most probable.
    group_source : str or None
        What makes a group.
    groups : int
        How many groups were taken out in turn; 0 where none were.
    """

    points_that_matter: tuple[Removal, ...]
    groups_that_matter: tuple[Removal, ...]
    group_source: str | None
    groups: int


@dataclass(frozen=True, kw_only=True, repr=False)
class FamilyVerdict(Verdict):
    """What to conclude of family, order and position together.

    Attributes
    ----------
    compared : int
        Number of models.
    plausible : tuple of Key
        Smallest set, by falling probability, that reaches 0.95.
    families, positions : dict of str to float
        Probability of each family and of each treatment of the position.
    log_bayes_factor : float or None
        ln B of the best model against the best of any other family.
    """

    best: Key
    compared: int
    plausible: tuple[Key, ...]
    families: dict[str, float]
    positions: dict[str, float]
    log_bayes_factor: float | None

    @property
    def recommended(self) -> str:
        """Name the most probable model."""
        return str(self.best)

    @property
    def standing(self) -> str:
        """How the most probable model stands, in a few words."""
        return standing_among(self, self.compared)

    @property
    def headline(self) -> str:
        """The outcome in a sentence."""
        name, withheld = _sentence(self.best), listed_words(self.withheld)
        if self.compared == 1:
            only = f"{name} is the only model compared"
            return f"{only}, and {withheld}." if withheld else f"{only}."
        named = list(zip(self.plausible, self.chances, strict=True))[1:]
        rest = "; ".join(f"{key} ({percent(chance)})" for key, chance in named[:NAMED])
        more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
        open_ = f"{rest}{more} can't be excluded at 95%" if named else ""
        chance = percent(self.chances[0])
        if withheld:
            why = f"{open_}, and {withheld}" if open_ else withheld
            return f"{name} is the best of those compared, {chance}; not decided: {why}."
        outcome = f"not decided: {open_}" if open_ else DECIDED
        return f"{name} is the most probable model, {chance}; {outcome}."


def _sentence(name: Key) -> str:
    words = str(name)
    return words[0].upper() + words[1:]


@dataclass(frozen=True, eq=False)
class FamilyComparison:
    """Families, orders and treatments of the position, compared on the joint data.

    Attributes
    ----------
    models : tuple of JointModel
        The most probable first.
    request : FamilyRequest
        Which models were asked for.
    settings : Settings
        Noise level, prior, seed and so on, as asked for.
    priors : tuple of str
        One line for each.
    noise : tuple of str
        How the noise level of r and of c was chosen.
    adequacy : tuple of AdequacyTest
        Of the most probable model's residuals, where the noise is Gaussian.
    grouped : GroupedErrors or None
        Of the most probable model, where the noise is Gaussian and points have groups.
    defence : FamilyDefence or None
        Answers to a referee, where they were asked for.
    origin : dict or None
        As of `bayescal.comparison.results.Comparison`.
    derived : dict of str to Any
        What else took long, by name: a run keeps it.
    """

    points: Correspondences
    models: tuple[JointModel, ...]
    request: FamilyRequest
    settings: Settings
    priors: tuple[str, ...]
    noise: tuple[str, ...]
    verdict: FamilyVerdict
    notes: tuple[str, ...]
    adequacy: tuple[AdequacyTest, ...] = ()
    grouped: GroupedErrors | None = None
    defence: FamilyDefence | None = None
    origin: dict[str, Any] | None = None
    derived: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def probabilities(self) -> tuple[float, ...]:
        """Probability of each model, in the same order."""
        return tuple(m.probability or 0.0 for m in self.models)

    @property
    def best(self) -> JointModel:
        """The most probable model."""
        return self.models[0]

    @property
    def sound(self) -> bool:
        """Whether all draws met the stopping rule."""
        return all(m.sound for m in self.models)

    def __iter__(self) -> Iterator[JointModel]:
        return iter(self.models)

    def __len__(self) -> int:
        return len(self.models)

    def __contains__(self, name: object) -> bool:
        return any(str(model.key) == name for model in self.models)

    def to_dataframe(self) -> pd.DataFrame:
        """Models in a data frame of pandas, a row each, the most probable first."""
        return models_frame(self.models)

    def summary(self) -> pd.DataFrame:
        """Parameters of the most probable model in a data frame of pandas."""
        return self.best.summary()

    def __getitem__(self, name: str) -> JointModel:
        for model in self.models:
            if str(model.key) == name:
                return model
        raise KeyError(f"{name!r} was not compared; compared: {[str(m.key) for m in self.models]}")

    def __repr__(self) -> str:
        return f"<FamilyComparison: {self.verdict.text}>"

    def _repr_html_(self) -> str:
        """Show the verdict in a notebook, and what was assumed."""
        return self.verdict._repr_html_() + bullets("Notes", self.notes)
