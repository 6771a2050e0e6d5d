"""Draws of a model, summarised: what every posterior offers, however it is checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.chains.chain import Chain
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.evidence import NEAR_BOUND
from bayescal.linear.model import LinearModel
from bayescal.markup import table
from bayescal.rounding import rounded, significant

if TYPE_CHECKING:  # a closed form needs none of these
    from bayescal.inference.estimate import EvidenceEstimate
    from bayescal.inference.optimum import Mode
    from bayescal.inference.sampled_model import SampledModel

INTERVAL_PROBABILITY = 0.95


@dataclass(frozen=True)
class ParameterSummary:
    """What the draws say of one parameter, beside the closed form.

    Attributes
    ----------
    mean, sd : float
        Of the draws, px (tau: fraction of the image).
    interval : tuple of float
        Central (equal-tailed) interval of the draws.
    mcse_mean : float
        Monte Carlo standard error of the mean.
    ess_bulk, ess_tail, rhat : float
        Rank-normalised diagnostics (Vehtari et al. 2021).
    exact_mean, exact_sd : float or None
        Of the closed form, where there is one.
    deviation : float or None
        The larger of the distances of mean and sd from it, in Monte Carlo standard
        errors.
    """

    name: str
    mean: float
    sd: float
    interval: tuple[float, float]
    interval_probability: ClassVar[float] = INTERVAL_PROBABILITY
    mcse_mean: float
    ess_bulk: float
    ess_tail: float
    rhat: float
    exact_mean: float | None = None
    exact_sd: float | None = None
    deviation: float | None = None

    @property
    def ess(self) -> float:
        """The smaller of bulk and tail effective sample size."""
        return min(self.ess_bulk, self.ess_tail)


class Posterior(Protocol):
    """Draws of emcee with their summaries, the evidence, and what tells whether to trust both."""

    @property
    def model(self) -> LinearModel | SampledModel:
        """What the draws are of."""
        ...

    @property
    def chain(self) -> Chain:
        """Draws of the reported parameters, and of what was sampled."""
        ...

    @property
    def full(self) -> Array:
        """Completed draws, ``(n_chains, n_draws, n_full)``."""
        ...

    @property
    def parameters(self) -> tuple[ParameterSummary, ...]:
        """One for each reported parameter, in the order of the draws' last axis."""
        ...

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        ...

    @property
    def exact(self) -> ExactPosterior | None:
        """The closed form; None where there is none."""
        ...

    @property
    def log_evidence(self) -> float | None:
        """Natural log of the evidence; None under a flat prior."""
        ...

    @property
    def log_evidence_error(self) -> float | None:
        """Its error, nat: a bound of the closed form's, else a Monte Carlo standard error."""
        ...

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the evidence should not be trusted; empty where it can be."""
        ...

    @property
    def converged(self) -> bool:
        """Whether the stopping rule was met."""
        ...

    @property
    def sound(self) -> bool:
        """Whether the draws converged and agree with the closed form, or the evidence is sure."""
        ...

    @property
    def agrees_with_exact(self) -> bool | None:
        """Whether means and sds are those of the closed form; None where there is none."""
        ...

    @property
    def estimate(self) -> EvidenceEstimate | None:
        """The evidence from draws; None where it has a closed form."""
        ...

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Modes that were found, the highest first; none where a closed form knows better."""
        ...

    def __getitem__(self, name: str) -> ParameterSummary:
        """Give the summary of a parameter."""
        ...

    def at_bounds(self, name: str, bounds: tuple[float, float]) -> tuple[float, float]:
        """Probability that a scale lies within 5 % of its lower, upper bound."""
        ...


@dataclass(frozen=True, eq=False)
class Summarised:
    """What posteriors have in common: a chain and the summaries of its parameters."""

    chain: Chain
    parameters: tuple[ParameterSummary, ...]

    @property
    def converged(self) -> bool:
        """Whether the stopping rule was met."""
        return self.chain.converged

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the draws' last axis."""
        return tuple(p.name for p in self.parameters)

    def __getitem__(self, name: str) -> ParameterSummary:
        return self.parameters[self.names.index(name)]

    def at_bounds(self, name: str, bounds: tuple[float, float]) -> tuple[float, float]:
        """Probability that a scale lies within 5 % of its lower, upper bound, of the draws."""
        values, (low, high) = self.chain.draws[:, :, self.names.index(name)], bounds
        return (
            float(np.mean(values < low * (1 + NEAR_BOUND))),
            float(np.mean(values > high / (1 + NEAR_BOUND))),
        )

    @property
    def title(self) -> str:
        """How many draws there are."""
        chains, draws, _ = self.chain.draws.shape
        return f"{chains} chains of {draws} draws"

    def __repr__(self) -> str:
        lines = [f"  {p.name} = {p.mean:.6g} ± {p.sd:.2g}" for p in self.parameters]
        return "\n".join([f"<Posterior: {self.title}", *lines]) + ">"

    def _repr_html_(self) -> str:
        """Show the parameters in a notebook."""
        return parameters_table(f"{self.title[0].upper()}{self.title[1:]}{UNITS}", self.parameters)


UNITS = "; coefficients and sigma in px (the unit of y for arrays), tau a fraction of the image"


def parameters_table(caption: str, parameters: Sequence[ParameterSummary]) -> str:
    """Summaries as an HTML table, digits cut to their uncertainty."""
    rows = [
        [
            p.name,
            rounded(p.mean, p.sd),
            significant(p.sd),
            " to ".join(rounded(end, p.sd) for end in p.interval),
            f"{p.ess_bulk:.0f}",
            f"{p.ess_tail:.0f}",
            f"{p.rhat:.3f}",
        ]
        for p in parameters
    ]
    interval = f"{100 * INTERVAL_PROBABILITY:g}% interval"
    heads = ["parameter", "mean", "sd", interval, "ESS bulk", "ESS tail", "R-hat"]
    return table(caption, heads, rows)


def summarise(names: tuple[str, ...], chain: Chain) -> tuple[ParameterSummary, ...]:
    """Summarise the draws of every reported parameter."""
    flat = chain.draws.reshape(-1, chain.draws.shape[2])
    tail = (1 - INTERVAL_PROBABILITY) / 2
    lower, upper = np.quantile(flat, [tail, 1 - tail], axis=0)
    means, sds = flat.mean(axis=0), flat.std(axis=0, ddof=1)
    return tuple(
        ParameterSummary(
            name,
            float(means[j]),
            float(sds[j]),
            (float(lower[j]), float(upper[j])),
            float(sds[j] / np.sqrt(found.ess_mean)),
            found.ess_bulk,
            found.ess_tail,
            found.rhat,
        )
        for j, (name, found) in enumerate(zip(names, chain.diagnostics, strict=True))
    )
