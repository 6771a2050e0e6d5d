"""One store of draws: each candidate's posterior is had once, by its key."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar, cast

from bayescal.comparison.key import Key
from bayescal.linear.model import LinearModel

if TYPE_CHECKING:  # Gaussian noise does not pay for what it does not need
    from bayescal.comparison.defence.stability import Beyond
    from bayescal.comparison.judged import Judged
    from bayescal.comparison.leave_one_out import LeaveOneOut
    from bayescal.inference.checked_posterior import CheckedPosterior
    from bayescal.inference.sampled_model import SampledModel
    from bayescal.inference.sampled_posterior import SampledPosterior
    from bayescal.inference.weighting import WeightedDraws

    Kept = CheckedPosterior | SampledPosterior | WeightedDraws

Draws = TypeVar("Draws", bound="Kept")


class Store:
    """Posteriors by the keys of their models: computed now, or read from a run (`read`)."""

    def __init__(self) -> None:
        self._kept: dict[Key, Kept] = {}

    def posterior(
        self,
        key: Key,
        model: LinearModel | SampledModel,
        compute: Callable[[], Draws],
        *,
        beside: bool = False,
    ) -> Draws:
        """Posterior of a model: the one already had, else that of a run, else computed.

        A run need not have kept a model that stands `beside` those compared.
        """
        if key not in self._kept:
            self._kept[key] = self.read(key, model, beside=beside) or compute()
        return cast("Draws", self._kept[key])

    def read(
        self,
        key: Key,  # noqa: ARG002 - for those who keep draws
        model: LinearModel | SampledModel,  # noqa: ARG002
        *,
        beside: bool,  # noqa: ARG002
    ) -> Kept | None:
        """Posterior that was kept of a model; None where it is to be computed."""
        return None

    def leave_one_out(
        self,
        key: Key,  # noqa: ARG002
        compute: Callable[[], LeaveOneOut | None],
    ) -> LeaveOneOut | None:
        """Leave-one-out of a model from its draws: that of a run, else computed."""
        return compute()

    def wins(self, axis: str, unit: str) -> dict[int, float] | None:  # noqa: ARG002
        """Share of an axis's resamples that each order won; None where not yet known."""
        return None

    def beyond(self, axis: str, highest: int) -> Beyond | None:  # noqa: ARG002
        """Judge the orders of an axis above the `highest` compared; None where not yet known."""
        return None

    def noises(self, axis: str) -> tuple[Judged, ...] | None:  # noqa: ARG002
        """Judge the recommended order under other noise; None where not yet known."""
        return None
