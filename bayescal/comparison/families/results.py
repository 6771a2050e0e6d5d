"""Models of the joint data, whatever their family, on one scale."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from bayescal.comparison.faces.face import Lists, Recommends
from bayescal.comparison.faces.frames import models_frame
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.verdict import FamilyVerdict
from bayescal.markup import bullets
from bayescal.points.correspondences import Correspondences

if TYPE_CHECKING:
    import pandas as pd

    from bayescal.comparison.adequacy.outcome import AdequacyTest
    from bayescal.comparison.defence.stability import Removal
    from bayescal.comparison.settings import Settings
    from bayescal.polynomials.whole import Whole


@dataclass(frozen=True, eq=False)
class GroupedErrors:
    """Deviations of a model's parameters by the jackknife over groups of points.

    Attributes
    ----------
    source : str
        What makes a group: ``"column group"`` or ``"plane z"``.
    count : int
        Groups.
    sd : dict of str to float
        Of each parameter but those of the noise, in its unit.
    """

    source: str
    count: int
    sd: dict[str, float]


@dataclass(frozen=True, eq=False)
class FamilyDefence:
    """Answers to a referee, on models of r and c together.

    Attributes
    ----------
    points_that_matter, groups_that_matter : tuple of Removal
        Whose removal makes another model the most probable.
    group_source : str or None
        What makes a group.
    groups : int
        How many groups were taken out in turn; 0 where none were.
    """

    points_that_matter: tuple[Removal, ...]
    groups_that_matter: tuple[Removal, ...]
    group_source: str | None
    groups: int


@dataclass(frozen=True, eq=False)
class FamilyComparison(Recommends, Lists[str, JointModel]):
    """Families, orders and treatments of the position, compared on the joint data.

    Attributes
    ----------
    models : tuple of JointModel
        The most probable first.
    request : FamilyRequest
        Which models were asked for.
    settings : Settings
        Noise level, prior, seed and so on, as asked for.
    priors : tuple of str
        One line for each.
    noise : tuple of str
        How the noise level of r and of c was chosen.
    adequacy : tuple of AdequacyTest
        Of the most probable model's residuals, where the noise is Gaussian.
    grouped : GroupedErrors or None
        Of the most probable model, where the noise is Gaussian and points have groups.
    defence : FamilyDefence or None
        Answers to a referee, where they were asked for.
    origin : dict or None
        As of `bayescal.comparison.results.Comparison`.
    derived : dict of str to Any
        What else took long, by name: a run keeps it.
    whole : mapping of str to Whole, or None
        All points, reduced for each axis of each family, where `points` are a sample of them.
    """

    points: Correspondences
    models: tuple[JointModel, ...]
    request: FamilyRequest
    settings: Settings
    priors: tuple[str, ...]
    noise: tuple[str, ...]
    verdict: FamilyVerdict
    notes: tuple[str, ...]
    adequacy: tuple[AdequacyTest, ...] = ()
    grouped: GroupedErrors | None = None
    defence: FamilyDefence | None = None
    origin: dict[str, Any] | None = None
    derived: dict[str, Any] = field(default_factory=dict, repr=False)
    whole: Mapping[str, Whole] | None = None

    @property
    def probabilities(self) -> tuple[float, ...]:
        """Probability of each model, in the same order."""
        return tuple(m.probability or 0.0 for m in self.models)

    @property
    def best(self) -> JointModel:
        """The most probable model."""
        return self.models[0]

    @property
    def sound(self) -> bool:
        """Whether all draws met the stopping rule."""
        return all(m.sound for m in self.models)

    absent = "{0!r} was not compared; compared: {1}"

    def named(self) -> list[tuple[str, JointModel]]:
        """List the models."""
        return [(str(model.key), model) for model in self.models]

    def to_dataframe(self) -> pd.DataFrame:
        """Models in a data frame of pandas, a row each, the most probable first."""
        return models_frame(self.models)

    @property
    def chosen(self) -> JointModel:
        """The most probable model, whose posterior is handed on."""
        return self.best

    def __repr__(self) -> str:
        return f"<FamilyComparison: {self.verdict.text}>"

    def _repr_html_(self) -> str:
        """Show the verdict in a notebook, and what was assumed."""
        return self.verdict._repr_html_() + bullets("Notes", self.notes)
