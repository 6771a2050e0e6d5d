"""One store of draws: each candidate's posterior is made once, by its key."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

from bayescal.comparison.key import Key
from bayescal.linear.model import LinearModel

if TYPE_CHECKING:  # Gaussian noise does not pay for what it does not need
    from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
    from bayescal.inference.checked_posterior import CheckedPosterior
    from bayescal.inference.sampled_model import SampledModel
    from bayescal.inference.sampled_posterior import SampledPosterior
    from bayescal.inference.weighting import WeightedDraws

    Kept = CheckedPosterior | SampledPosterior | WeightedDraws

Draws = TypeVar("Draws", bound="Kept")
Made = TypeVar("Made")
# What takes long, by its name, type and how to have it.
Once: TypeAlias = Callable[[str, Any, Callable[[], Any]], Any]


def now(name: str, kind: Any, compute: Callable[[], Made]) -> Made:  # noqa: ARG001
    """Have a value where there is no store."""
    return compute()


class Store:
    """Posteriors by the keys of their models: computed now, or read from a run (`read`).

    Attributes
    ----------
    derived : dict of str to Any
        What else took long, by name (`once`): a run keeps it.
    """

    def __init__(self) -> None:
        self._kept: dict[Key, Kept] = {}
        self.derived: dict[str, Any] = {}

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
            found = self.read(key, model, beside=beside)
            if found is None:
                self.made(key, found := compute())
            self._kept[key] = found
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

    def made(self, key: Key, found: Kept) -> None:
        """Take note of a posterior that was computed."""

    def once(self, name: str, kind: Any, compute: Callable[[], Made]) -> Made:
        """Give what takes long and follows from the points alone: that of a run, else computed.

        Parameters
        ----------
        name : str
            Of the value, such as ``"r-order-4 leave-one-out"``.
        kind : type
            Of the value, as `bayescal.encoding` takes it.
        """
        if name not in self.derived:
            known = self.known(name, kind)
            if known is None:
                self.noted(name, value := compute())
                known = (value,)
            self.derived[name] = known[0]
        return cast("Made", self.derived[name])

    def once_of(self, key: Key) -> Once:
        """Give `once` for values of one model."""
        return lambda name, kind, compute: self.once(f"{key.file()} {name}", kind, compute)

    def known(self, name: str, kind: Any) -> tuple[Any] | None:  # noqa: ARG002
        """Value that was kept under a name, alone in a tuple; None where it is to be computed."""
        return None

    def noted(self, name: str, value: Any) -> None:
        """Take note of a value that was computed."""

    def leave_one_out(
        self, key: Key, compute: Callable[[], LeaveOneOut | None], how: str = ""
    ) -> LeaveOneOut | None:
        """Leave-one-out of a model, once."""
        from bayescal.comparison.criteria.leave_one_out import LeaveOneOut

        return self.once(f"{key.file()} leave-one-out{how}", LeaveOneOut | None, compute)
