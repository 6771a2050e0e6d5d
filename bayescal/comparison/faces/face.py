"""What every result offers Python alike: it iterates, indexes, and hands its posterior on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from bayescal.comparison.faces.convert import Converts

if TYPE_CHECKING:  # pandas is imported where somebody asks for it
    import pandas as pd


Name = TypeVar("Name")
Item = TypeVar("Item")


class Lists(ABC, Generic[Name, Item]):
    """A result that iterates over its parts and finds them by their names."""

    # Said of a name that none has, {0}, among those that there are, {1}.
    absent: ClassVar[str]

    @abstractmethod
    def named(self) -> Sequence[tuple[Name, Item]]:
        """List the parts with their names."""

    def __iter__(self) -> Iterator[Item]:
        return iter([item for _, item in self.named()])

    def __len__(self) -> int:
        return len(self.named())

    def __contains__(self, name: object) -> bool:
        return any(name == own or name is item for own, item in self.named())

    def __getitem__(self, name: Name) -> Item:
        for own, item in self.named():
            if own == name:
                return item
        names = ", ".join(str(own) for own, _ in self.named())
        raise KeyError(self.absent.format(name, names))


class Recommends(ABC):
    """A result of which one model is recommended: its posterior is the result's."""

    @property
    @abstractmethod
    def chosen(self) -> Converts:
        """The recommended model."""

    def summary(self) -> pd.DataFrame:
        """Parameters of the recommended model in a data frame: mean, sd, 95 % interval."""
        return self.chosen.summary()

    def covariance(self) -> pd.DataFrame:
        """Posterior covariance of the recommended model's parameters in a data frame."""
        return self.chosen.covariance()

    def to_arviz(self) -> Any:
        """Draws, log likelihood and data of the recommended model for ArviZ."""
        return self.chosen.to_arviz()


Axis = TypeVar("Axis", bound=Recommends)


class ByAxis(Lists[str, Axis]):
    """A result axis by axis.

    Attributes
    ----------
    axes : dict of str to Axis
        ``"r"`` and ``"c"``, or ``"y"`` for a generic problem.
    """

    absent = "axis {0!r} was not looked at; axes: {1}"
    axes: dict[str, Axis]

    def named(self) -> list[tuple[str, Axis]]:
        """List the axes."""
        return list(self.axes.items())

    def summary(self) -> pd.DataFrame:
        """Parameters of each axis's recommended model in a data frame of pandas."""
        import pandas as pd

        found = {name: axis.summary() for name, axis in self.axes.items()}
        return pd.concat(found, names=["axis"])

    def covariance(self) -> pd.DataFrame:
        """Posterior covariance of the parameters of all axes, which are independent."""
        import pandas as pd

        found = {name: axis.covariance() for name, axis in self.axes.items()}
        rows = pd.concat(
            {name: pd.concat({name: frame}, axis=1) for name, frame in found.items()},
            names=["axis", "parameter"],
        )
        return rows.rename_axis(["axis", "parameter"], axis=1).fillna(0.0)

    def to_arviz(self) -> dict[str, Any]:
        """Draws, log likelihood and data of each axis's recommended model for ArviZ, by axis."""
        return {name: axis.to_arviz() for name, axis in self.axes.items()}
