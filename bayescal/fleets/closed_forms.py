"""Posteriors of a fleet's cameras: what has a closed form is drawn only where draws are asked for.

A fleet keeps means, deviations and probabilities. Where these have a closed form, draws would
add nothing but Monte Carlo error, and cost as much as everything else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

from bayescal.comparison.key import Key
from bayescal.comparison.store import Draws, Store
from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.linear.model import LinearModel

if TYPE_CHECKING:
    from bayescal.inference.posterior import Posterior
    from bayescal.inference.sampled_model import SampledModel


class ClosedForms(Store):
    """A store that leaves models with a closed form undrawn."""

    def posterior(
        self,
        key: Key,
        model: LinearModel | SampledModel,
        compute: Callable[[], Draws],
        *,
        beside: bool = False,
    ) -> Draws:
        """Posterior of a model: undrawn where it has a closed form, else computed."""
        if not isinstance(model, LinearModel):
            return super().posterior(key, model, compute, beside=beside)
        found = Undrawn(exact_posterior(model), cast("Callable[[], Posterior]", compute))
        return super().posterior(key, model, lambda: cast("Draws", found), beside=beside)


@dataclass(frozen=True, eq=False)
class Undrawn:
    """A posterior in closed form, which is drawn when something else of it is asked for."""

    exact: ExactPosterior
    draw: Callable[[], Posterior]
    agrees_with_exact = None
    converged = sound = True
    warnings = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.exact.model.names

    @property
    def log_evidence(self) -> float | None:
        """Natural log of the evidence; None under a flat prior."""
        return self.exact.log_evidence

    @property
    def log_evidence_error(self) -> float | None:
        """Bound on its error, nat; None under a flat prior."""
        return self.exact.log_evidence_error

    def at_bounds(self, *_: object) -> tuple[float, float]:
        """Probability that sigma lies within 5 % of its lower, upper bound."""
        return self.exact.sigma_at_bounds()

    @cached_property
    def _drawn(self) -> Posterior:
        return self.draw()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._drawn, name)
