"""A posterior sampled with emcee and checked against the closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.chains.chain import Chain
from bayescal.inference.posterior import ParameterSummary, Summarised, summarise
from bayescal.inference.proposals.proposal import LinearProposal, Proposal
from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.linear.model import LinearModel

if TYPE_CHECKING:
    from bayescal.inference.optimum import Mode

# A mean or sd further than this many Monte Carlo standard errors from the closed
# form is an error of the program, not of chance.
AGREEMENT = 5.0


@dataclass(frozen=True, eq=False, repr=False)
class CheckedPosterior(Summarised):
    """Posterior of one order: draws of emcee beside the closed form, `exact`."""

    exact: ExactPosterior

    @property
    def model(self) -> LinearModel:
        """What the draws are of."""
        return self.exact.model

    @property
    def agrees_with_exact(self) -> bool:
        """Whether every mean and sd is within 5 Monte Carlo errors of the closed form."""
        return all(p.deviation is None or p.deviation < AGREEMENT for p in self.parameters)

    @property
    def sound(self) -> bool:
        """Whether the draws converged and agree with the closed form."""
        return self.converged and self.agrees_with_exact

    @property
    def log_evidence(self) -> float | None:
        """Natural log of the evidence; None under a flat prior."""
        return self.exact.log_evidence

    @property
    def log_evidence_error(self) -> float | None:
        """Bound on its error, nat; None under a flat prior."""
        return self.exact.log_evidence_error

    @property
    def warnings(self) -> tuple[str, ...]:
        """Nothing: the evidence is that of the closed form."""
        return ()

    @property
    def estimate(self) -> None:
        """There is none: the evidence is that of the closed form."""
        return

    @property
    def modes(self) -> tuple[Mode, ...]:
        """None were looked for."""
        return ()

    @property
    def full(self) -> Array:
        """Draws of all that is sampled, ``(n_chains, n_draws, dimension)``."""
        return self.chain.theta

    def at_bounds(
        self,
        name: str,  # noqa: ARG002 - sigma is the only one
        bounds: tuple[float, float],  # noqa: ARG002
    ) -> tuple[float, float]:
        """Probability that sigma lies within 5 % of its lower, upper bound."""
        return self.exact.sigma_at_bounds()

    @property
    def title(self) -> str:
        """Which order, and how many draws there are."""
        return f"order {self.exact.model.order}, {super().title}"


def sample_posterior(
    model: LinearModel,
    rng: np.random.Generator,
    ess: int,
    exact: ExactPosterior | None = None,
    proposal: Proposal | None = None,
) -> CheckedPosterior:
    """Sample a linear model's posterior with emcee and check it.

    Parameters
    ----------
    ess : int
        Effective samples wanted of every parameter.
    exact : ExactPosterior, optional
        The closed form, where it is already at hand.
    proposal : Proposal, optional
        By default the closed form, interpolated.
    """
    from bayescal.inference.chains.sampling import sample

    exact = exact if exact is not None else exact_posterior(model)
    to_monomials = model.factors.monomials.lead(model.order).T

    def report(theta: Array) -> Array:
        coefficients = theta[:, : model.size] @ to_monomials
        return np.concatenate([coefficients, np.exp(theta[:, model.size :])], axis=1)

    chain = sample(
        lambda theta: log_prob(model, theta),
        proposal if proposal is not None else LinearProposal(exact),
        report,
        rng,
        ess,
    )
    return posterior_of(exact, chain)


def posterior_of(exact: ExactPosterior, chain: Chain) -> CheckedPosterior:
    """Summarise a chain, sampled now or read from a file, beside the closed form."""
    return CheckedPosterior(chain, _summaries(exact, chain), exact)


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
