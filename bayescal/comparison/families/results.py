"""Models of the joint data, whatever their family, on one scale."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bayescal.arrays import Array
from bayescal.comparison.key import FREE, PINHOLE, STATED, Key
from bayescal.points.correspondences import Correspondences

if TYPE_CHECKING:  # the hint in a comparison of orders samples nothing
    from bayescal.cameras.pinhole import Radial
    from bayescal.comparison.criteria import Criteria
    from bayescal.comparison.goodness import GoodnessOfFit
    from bayescal.comparison.settings import Settings
    from bayescal.inference.sampled_posterior import SampledPosterior
    from bayescal.inference.weighting import WeightedDraws
    from bayescal.linear.closed_form import ExactPosterior


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


@dataclass(frozen=True, eq=False)
class JointLeaveOneOut:
    """Leave-one-out of the joint data: r and c of a point together.

    Attributes
    ----------
    pointwise : Array
        ln p(t_i | all other points), ``(n_points,)``.
    pareto_k : float or None
        Largest of the points that draws tell of; None where it is exact.
    k_limit : float or None
        Below it `pareto_k` is good; fewer draws can judge thinner tails only.
    mcse : float
        Monte Carlo standard error of their sum.
    refitted : tuple of int
        Points whose term comes from the evidence without them, as their weights have too
        heavy a tail.
    """

    pointwise: Array
    pareto_k: float | None = None
    k_limit: float | None = None
    mcse: float = 0.0
    refitted: tuple[int, ...] = ()

    @property
    def elpd(self) -> float:
        """Sum of the terms."""
        return float(self.pointwise.sum())

    @property
    def se(self) -> float:
        """Its standard error: sqrt(n) times the sd (n - 1) of the terms."""
        return math.sqrt(len(self.pointwise)) * float(self.pointwise.std(ddof=1))

    @property
    def reliable(self) -> bool:
        """Whether it is exact, or every point's Pareto k is good."""
        if self.pareto_k is None or self.k_limit is None:
            return True
        return self.pareto_k < self.k_limit


@dataclass(frozen=True, eq=False)
class JointModel:
    """One model of the joint data, judged.

    Attributes
    ----------
    name : Key
    criteria : Criteria
        K counts coefficients, inferred sigmas and the position where it is free; n counts points.
        There are no criteria of an exact fit, nor under robust noise, whose likelihood may have
        no maximum (a sigma that shrinks about a few points).
    log_evidence : float
        Natural log.
    log_evidence_error : float
        Monte Carlo error, or the quadrature's, nat.
    loo : JointLeaveOneOut or None
        None where it can't be had.
    position : Array
        Camera position of highest likelihood, of a linear family under robust noise of highest
        posterior density, ``(3,)``, world units.
    posterior : SampledPosterior or None
        Of a model that was sampled: pinholes, a family's best at a free position, and under
        robust noise linear families at the stated one.
    doubts : tuple of str
        Why an evidence that was had without sampling should not be trusted.
    exact : tuple of ExactPosterior
        Of r and of c, at the stated position of a linear family; empty elsewhere.
    goodness : GoodnessOfFit or None
        Chi-squared of both axes, where no sigma is inferred.
    weighted : WeightedDraws or None
        Of a model that has no closed form and was not sampled.
    """

    name: Key
    criteria: Criteria
    log_evidence: float
    log_evidence_error: float
    loo: JointLeaveOneOut | None
    position: Array
    posterior: SampledPosterior | None = None
    doubts: tuple[str, ...] = ()
    exact: tuple[ExactPosterior, ...] = ()
    goodness: GoodnessOfFit | None = None
    weighted: WeightedDraws | None = None

    @property
    def sound(self) -> bool:
        """Whether its draws, if any, met the stopping rule and its evidence can be trusted."""
        return not self.warnings and (self.posterior is None or self.posterior.converged)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why its evidence should not be trusted."""
        return self.doubts if self.posterior is None else self.posterior.estimate.warnings


@dataclass(frozen=True, eq=False)
class FamilyVerdict:
    """What to conclude of family, order and position together.

    Attributes
    ----------
    best : Key
    plausible : tuple of Key
        Smallest set, by falling probability, that reaches 0.95.
    decided : bool
    families, positions : dict of str to float
        Probability of each family and of each treatment of the position.
    log_bayes_factor : float or None
        ln B of the best model against the best of any other family.
    caveats : tuple of str
    text : str
    """

    best: Key
    plausible: tuple[Key, ...]
    decided: bool
    families: dict[str, float]
    positions: dict[str, float]
    log_bayes_factor: float | None
    caveats: tuple[str, ...]
    text: str


@dataclass(frozen=True, eq=False)
class FamilyComparison:
    """Families, orders and treatments of the position, compared on the joint data.

    Attributes
    ----------
    points : Correspondences
    models : tuple of JointModel
        The most probable first.
    probabilities : tuple of float
        Of each, in the same order.
    request : FamilyRequest
        Which models were asked for.
    settings : Settings
        Noise level, prior, seed and so on, as asked for.
    priors : tuple of str
        One line for each.
    noise : tuple of str
        How the noise level of r and of c was chosen.
    verdict : FamilyVerdict
    notes : tuple of str
    origin : dict or None
        As of `bayescal.comparison.results.Comparison`.
    """

    points: Correspondences
    models: tuple[JointModel, ...]
    probabilities: tuple[float, ...]
    request: FamilyRequest
    settings: Settings
    priors: tuple[str, ...]
    noise: tuple[str, ...]
    verdict: FamilyVerdict
    notes: tuple[str, ...]
    origin: dict[str, Any] | None = None

    @property
    def best(self) -> JointModel:
        """The most probable model."""
        return self.models[0]

    @property
    def sound(self) -> bool:
        """Whether all draws met the stopping rule."""
        return all(m.sound for m in self.models)

    def __getitem__(self, name: str) -> JointModel:
        for model in self.models:
            if str(model.name) == name:
                return model
        raise KeyError(f"{name!r} was not compared; compared: {[str(m.name) for m in self.models]}")

    def __repr__(self) -> str:
        return f"<FamilyComparison: {self.verdict.text}>"
