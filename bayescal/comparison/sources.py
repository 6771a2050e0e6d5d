"""Where what takes long comes from: computed now, or read from a run that kept it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from bayescal.inference.posterior import Posterior
from bayescal.linear.model import LinearModel

if TYPE_CHECKING:  # Gaussian noise does not pay for what it does not need
    from bayescal.comparison.defence.noise_evidence import NoiseEvidence
    from bayescal.inference.sampled_model import SampledModel
    from bayescal.inference.sampled_posterior import SampledPosterior
    from bayescal.inference.weighting import WeightedDraws


class Source(Protocol):
    """Where what takes long comes from: computed now, or read from a run that kept it."""

    def posterior(
        self, name: str, model: LinearModel, compute: Callable[[], Posterior]
    ) -> Posterior:
        """Posterior of a model; `name`, such as ``"r-order-4"``, is its own in the comparison."""
        ...

    def sampled(
        self, name: str, model: SampledModel, compute: Callable[[], SampledPosterior]
    ) -> SampledPosterior:
        """Posterior of a model without a closed form."""
        ...

    def wins(self, axis: str, unit: str) -> dict[int, float] | None:
        """Share of bootstrap resamples of an axis each order won; None where not yet known."""
        ...

    def noises(self, axis: str) -> tuple[NoiseEvidence, ...] | None:
        """Evidence under other noise models of an axis's defence; None where not yet known."""
        ...


class DrawsSource(Protocol):
    """The same for models of r and c together."""

    def sampled(
        self, name: str, model: SampledModel, compute: Callable[[], SampledPosterior]
    ) -> SampledPosterior:
        """Posterior of a model that is sampled; `name` is its own in the comparison."""
        ...

    def weighted(
        self, name: str, model: SampledModel, compute: Callable[[], WeightedDraws]
    ) -> WeightedDraws:
        """Weighted draws of a model that is not."""
        ...


class Computed:
    """Everything computed now; models are sampled with emcee."""

    def posterior(
        self,
        name: str,  # noqa: ARG002 - for those who keep draws by name
        model: LinearModel,  # noqa: ARG002
        compute: Callable[[], Posterior],
    ) -> Posterior:
        """Sample a model."""
        return compute()

    def sampled(
        self,
        name: str,  # noqa: ARG002
        model: SampledModel,  # noqa: ARG002
        compute: Callable[[], SampledPosterior],
    ) -> SampledPosterior:
        """Sample a model without a closed form."""
        return compute()

    def weighted(
        self,
        name: str,  # noqa: ARG002
        model: SampledModel,  # noqa: ARG002
        compute: Callable[[], WeightedDraws],
    ) -> WeightedDraws:
        """Draw and weigh."""
        return compute()

    def wins(self, axis: str, unit: str) -> None:  # noqa: ARG002
        """Know nothing yet."""
        return

    def noises(self, axis: str) -> None:  # noqa: ARG002
        """Know nothing yet."""
        return
