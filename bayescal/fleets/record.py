"""What a fleet keeps of each camera: small enough for many, and the same on any machine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bayescal.comparison.results import AxisComparison, Comparison, OrderResult

if TYPE_CHECKING:  # a fleet of points does not pay for lenses
    from bayescal.comparison.lenses.results import JudgedLens, LensComparison

LENS = "lens"
DRAWS = 4000  # of the normals about a lens's modes


@dataclass(frozen=True)
class Estimate:
    """A parameter with its standard deviation; None where it is not known."""

    value: float
    sd: float | None


@dataclass(frozen=True)
class Choice:
    """What was chosen among several models.

    Attributes
    ----------
    of : str
        ``"r"``, ``"c"`` or ``"lens"``.
    model : str
        The recommended order or lens.
    outcome : str or None
        Of the verdict, in a word; None where there is no evidence.
    plausible : tuple of str
        Models that can't be excluded at 95 %.
    probability : dict of str to float
        Of every model; empty where there is no evidence.
    sigma : Estimate
        Spread of the residuals of the recommended model, px.
    parameters : dict of str to dict of str to Estimate
        Of every model, by name.
    """

    of: str
    model: str
    outcome: str | None
    plausible: tuple[str, ...]
    probability: dict[str, float]
    sigma: Estimate
    parameters: dict[str, dict[str, Estimate]]


@dataclass(frozen=True)
class Record:
    """What is kept of a camera that was judged.

    Attributes
    ----------
    n_points : int
    seed : int
        Of its random numbers.
    sound : bool
        Whether draws converged and evidences can be trusted.
    choices : tuple of Choice
    """

    n_points: int
    seed: int
    sound: bool
    choices: tuple[Choice, ...]

    @classmethod
    def of_orders(cls, found: Comparison) -> Record:
        """Keep what a comparison of orders says."""
        n = 0 if found.points is None else len(found.points)
        return cls(n, found.seed, found.sound, tuple(map(_axis, found)))

    @classmethod
    def of_lenses(cls, found: LensComparison) -> Record:
        """Keep what a comparison of lenses says."""
        return cls(found.views.n_points, found.settings.seed, found.sound, (_lens(found),))

    def to_json(self) -> dict[str, Any]:
        """Give JSON values."""
        return asdict(self)

    @classmethod
    def from_json(cls, kept: Mapping[str, Any]) -> Record:
        """Take up what `to_json` gave.

        Raises
        ------
        KeyError, TypeError
            Where it is something else.
        """
        choices = []
        for choice in kept["choices"]:
            parameters = {
                model: {name: Estimate(**p) for name, p in own.items()}
                for model, own in choice["parameters"].items()
            }
            sigma, plausible = Estimate(**choice["sigma"]), tuple(choice["plausible"])
            given = {"sigma": sigma, "plausible": plausible, "parameters": parameters}
            choices.append(Choice(**{**choice, **given}))
        return cls(**{**kept, "choices": tuple(choices)})


@dataclass(frozen=True)
class Member:
    """What became of a camera.

    Attributes
    ----------
    name, file : str
    record : Record or None
    error : str
        Why there is none.
    """

    name: str
    file: str
    record: Record | None
    error: str = ""


def _axis(axis: AxisComparison) -> Choice:
    chosen, dof = axis.chosen, axis.chosen.fit.dof
    sigma = math.sqrt(chosen.rss_px2 / dof) if dof > 0 else 0.0
    return Choice(
        axis.data.axis,
        str(chosen.order),
        axis.verdict.outcome,
        tuple(map(str, axis.verdict.plausible)),
        {str(r.order): r.probability for r in axis if r.probability is not None},
        Estimate(sigma, sigma / math.sqrt(2 * dof) if dof > 0 else None),
        {
            str(r.order): {
                name: estimate
                for name, estimate in _summary(r).items()
                if name.startswith(f"{axis.data.symbol}_")
            }
            for r in axis
        },
    )


def _summary(found: OrderResult) -> dict[str, Estimate]:
    """Mean and sd of every parameter: of the closed form, or of the draws where there is none."""
    if found.exact is None:
        return {p.name: Estimate(p.mean, p.sd) for p in found.posterior.parameters}
    means, sds = found.exact.summary
    estimates = map(Estimate, means.tolist(), sds.tolist())
    return dict(zip(found.exact.model.names, estimates, strict=True))


def _lens(found: LensComparison) -> Choice:
    """Keep lenses as their most probable error model has them, and sigma as the RMS tells it."""
    from bayescal.calibration.judging.laplace import degrees

    best, data, verdict = found.best, found.setting.data, found.verdict
    parameters = {lens.name: _estimates(lens, data.diagonal) for lens in found.lenses}
    dof = degrees(data) - best.model.dimension
    sigma = math.sqrt(best.fit.sum_of_squares / dof) if dof > 0 else 0.0
    return Choice(
        LENS,
        best.name,
        verdict.status,
        verdict.plausible,
        {lens.name: lens.probability for lens in found.lenses},
        Estimate(sigma, sigma / math.sqrt(2 * dof) if dof > 0 else None),
        parameters,
    )


def _estimates(lens: JudgedLens, diagonal: float) -> dict[str, Estimate]:
    """Mean and sd of a lens's parameters, by draws of the normals about its modes."""
    problem = lens.evidence.problem
    found = problem.laplace
    mean, covariance = problem.x + found.mean, found.covariance
    rng = np.random.default_rng(0)
    draws = rng.multivariate_normal(mean, covariance, DRAWS, method="cholesky")
    reported = problem.model.report(draws, diagonal)
    each = zip(problem.model.names, reported.mean(axis=0), reported.std(axis=0), strict=True)
    return {name: Estimate(float(value), float(sd)) for name, value, sd in each}
