"""A run in place of the sampler: draws are read where they would be computed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bayescal.comparison.defence.noise_evidence import NoiseEvidence
from bayescal.inference.posterior import Posterior, posterior_of
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.inference.stored import unpack, unpack_sampled, unpack_weighted
from bayescal.inference.weighting import WeightedDraws
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.report.run.files import RunFiles

# ruff: noqa: ARG002 - nothing is computed


@dataclass(frozen=True)
class StoredDraws:
    """The draws of a run (as a `bayescal.comparison.sources.Source` and `DrawsSource`)."""

    run: RunFiles

    def posterior(
        self, name: str, model: LinearModel, compute: Callable[[], Posterior]
    ) -> Posterior:
        """Read the draws of a model with a closed form."""
        chain = self.run.read_draws(name, lambda draws: unpack(draws, model.names))
        return posterior_of(exact_posterior(model), chain)

    def sampled(
        self, name: str, model: SampledModel, compute: Callable[[], SampledPosterior]
    ) -> SampledPosterior:
        """Read the draws and the evidence of a model without one."""
        return self.run.read_draws(name, lambda draws: unpack_sampled(draws, model))

    def weighted(
        self, name: str, model: SampledModel, compute: Callable[[], WeightedDraws]
    ) -> WeightedDraws:
        """Read the weighted draws of a model that was not sampled."""
        return self.run.read_draws(name, lambda draws: unpack_weighted(draws, model))

    def wins(self, axis: str, unit: str) -> dict[int, float] | None:
        """Know of no resamples."""
        return None

    def noises(self, axis: str) -> tuple[NoiseEvidence, ...] | None:
        """Know of no other noise models."""
        return None
