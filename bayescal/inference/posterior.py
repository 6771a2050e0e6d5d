"""A sampled posterior, summarised and checked against the closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.coordinates import Whitening
from bayescal.inference.proposal import LinearProposal, Proposal
from bayescal.inference.sampling import Chain, sample
from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.markup import table
from bayescal.rounding import rounded, significant

# A mean or sd further than this many Monte Carlo standard errors from the closed
# form is an error of the program, not of chance.
AGREEMENT = 5.0
INTERVAL_PROBABILITY = 0.95


@dataclass(frozen=True)
class ParameterSummary:
    """What the draws say of one parameter, beside the closed form.

    Attributes
    ----------
    name : str
    mean, sd : float
        Of the draws, px (tau: fraction of the image).
    interval : tuple of float
        Central (equal-tailed) interval of the draws.
    interval_probability : float
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
    interval_probability: float
    mcse_mean: float
    ess_bulk: float
    ess_tail: float
    rhat: float
    exact_mean: float | None = None
    exact_sd: float | None = None
    deviation: float | None = None


@dataclass(frozen=True, eq=False)
class Posterior:
    """Posterior of one order: draws of emcee, checked against the closed form.

    Attributes
    ----------
    exact : ExactPosterior
    chain : Chain
    parameters : tuple of ParameterSummary
        Coefficients, then sigma, then tau, as far as they are inferred.
    """

    exact: ExactPosterior
    chain: Chain
    parameters: tuple[ParameterSummary, ...]

    @property
    def converged(self) -> bool:
        """Whether the stopping rule was met."""
        return self.chain.converged

    @property
    def agrees_with_exact(self) -> bool:
        """Whether every mean and sd is within 5 Monte Carlo errors of the closed form."""
        return all(p.deviation is None or p.deviation < AGREEMENT for p in self.parameters)

    @property
    def log_evidence(self) -> float | None:
        """Natural log of the evidence; None under a flat prior."""
        return self.exact.log_evidence

    @property
    def log_evidence_error(self) -> float | None:
        """Bound on its error, nat; None under a flat prior."""
        return self.exact.log_evidence_error

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the draws' last axis."""
        return self.exact.model.names

    def __getitem__(self, name: str) -> ParameterSummary:
        return self.parameters[self.names.index(name)]

    def __repr__(self) -> str:
        chains, draws, _ = self.chain.draws.shape
        lines = [f"<Posterior: order {self.exact.model.order}, {chains} chains of {draws} draws"]
        lines += [f"  {p.name} = {p.mean:.6g} +- {p.sd:.2g}" for p in self.parameters]
        return "\n".join(lines) + ">"

    def _repr_html_(self) -> str:
        """Show the parameters in a notebook."""
        chains, draws, _ = self.chain.draws.shape
        return parameters_table(
            f"Order {self.exact.model.order}, {chains} chains of {draws} draws; coefficients and "
            "sigma in px (the unit of y for arrays), tau a fraction of the image",
            self.parameters,
        )


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


def sample_posterior(
    model: LinearModel,
    rng: np.random.Generator,
    ess: int,
    exact: ExactPosterior | None = None,
    proposal: Proposal | None = None,
) -> Posterior:
    """Sample a linear model's posterior with emcee and check it.

    Parameters
    ----------
    model : LinearModel
    rng : numpy.random.Generator
    ess : int
        Effective samples wanted of every parameter.
    exact : ExactPosterior, optional
        The closed form, where it is already at hand.
    proposal : Proposal, optional
        By default the closed form, interpolated.

    Returns
    -------
    Posterior
    """
    exact = exact if exact is not None else exact_posterior(model)
    to_monomials = model.factors.monomials.lead(model.order).T

    def report(theta: Array) -> Array:
        coefficients = theta[:, : model.size] @ to_monomials
        return np.concatenate([coefficients, np.exp(theta[:, model.size :])], axis=1)

    chain = sample(
        lambda theta: log_prob(model, theta),
        proposal if proposal is not None else LinearProposal(exact),
        Whitening.of(exact),
        report,
        rng,
        ess,
    )
    return posterior_of(exact, chain)


def posterior_of(exact: ExactPosterior, chain: Chain) -> Posterior:
    """Summarise a chain, sampled now or read from a file, beside the closed form."""
    return Posterior(exact, chain, _summaries(exact, chain))


def _summaries(exact: ExactPosterior, chain: Chain) -> tuple[ParameterSummary, ...]:
    exact_means, exact_sds = exact.summary
    out = []
    for j, summary in enumerate(summarise(exact.model.names, chain)):
        found = chain.diagnostics[j]
        mean, sd = float(exact_means[j]), float(exact_sds[j])
        # Errors from the exact moments: a heavy tail the draws missed can't hide itself.
        error_mean = sd / np.sqrt(found.ess_mean)
        error_sd = sd * np.sqrt((exact.kurtosis[j] - 1) / 4 / found.ess_sd)
        deviation = max(abs(summary.mean - mean) / error_mean, abs(summary.sd - sd) / error_sd)
        out.append(replace(summary, exact_mean=mean, exact_sd=sd, deviation=float(deviation)))
    return tuple(out)


def summarise(names: tuple[str, ...], chain: Chain) -> tuple[ParameterSummary, ...]:
    """Summarise the draws of every reported parameter.

    Parameters
    ----------
    names : tuple of str
    chain : Chain
    """
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
            INTERVAL_PROBABILITY,
            float(sds[j] / np.sqrt(found.ess_mean)),
            found.ess_bulk,
            found.ess_tail,
            found.rhat,
        )
        for j, (name, found) in enumerate(zip(names, chain.diagnostics, strict=True))
    )
