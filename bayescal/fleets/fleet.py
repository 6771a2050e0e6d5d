"""A fleet of cameras: what became of each, and what they say together."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from bayescal.fleets.odd import Oddity, Spread, choices_of, common_model, oddities, spreads
from bayescal.fleets.record import Choice, Member, Record
from bayescal.fleets.table import columns
from bayescal.points.heading import SILENT, Heading

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Fleet:
    """Cameras judged alike, and which of them are odd.

    Attributes
    ----------
    members : tuple of Member
        In the order given.
    settings : dict
        What was asked for of every camera.
    taken : int
        How many an earlier run had judged.
    heading : Heading
        What the title block of its page says.
    """

    members: tuple[Member, ...]
    settings: dict[str, Any] = field(default_factory=dict)
    taken: int = 0
    heading: Heading = SILENT

    @cached_property
    def records(self) -> dict[str, Record]:
        """Records by camera."""
        return {m.name: m.record for m in self.members if m.record is not None}

    @property
    def failed(self) -> tuple[Member, ...]:
        """Cameras that could not be judged."""
        return tuple(m for m in self.members if m.record is None)

    @property
    def unsound(self) -> tuple[Member, ...]:
        """Cameras whose draws did not converge, or whose evidence should not be trusted."""
        return tuple(m for m in self.members if m.record is not None and not m.record.sound)

    @property
    def sound(self) -> bool:
        """Whether every camera was judged, and soundly."""
        return not self.failed and not self.unsound

    @cached_property
    def choices(self) -> dict[str, dict[str, Choice]]:
        """Choices by what they are of (``"r"``, ``"c"``, ``"lens"``) and by camera."""
        return choices_of(self.records)

    @cached_property
    def common(self) -> dict[str, str]:
        """Model recommended most often, by what it is of."""
        return {of: common_model(list(found.values())) for of, found in self.choices.items()}

    @cached_property
    def spreads(self) -> tuple[Spread, ...]:
        """Every quantity over the fleet."""
        return spreads(self.records)

    @cached_property
    def odd(self) -> tuple[Oddity, ...]:
        """Why cameras are odd, the oddest first."""
        return oddities(self.records, self.spreads)

    @cached_property
    def columns(self) -> dict[str, list[Any]]:
        """Columns of the table by name, an entry per camera; None where there is none.

        Parameters are those of the model recommended most often (`common`), whatever a camera's
        own: only then can cameras be compared.
        """
        return columns(self.members, self.choices, self.spreads, self.odd)

    def to_dataframe(self) -> pd.DataFrame:
        """Cameras in a data frame of pandas, a row each."""
        import pandas as pd

        return pd.DataFrame(self.columns).set_index("camera")

    def __len__(self) -> int:
        return len(self.members)

    def __repr__(self) -> str:
        odd, failed = len({o.camera for o in self.odd}), len(self.failed)
        return f"<Fleet: {len(self)} cameras, {odd} odd, {failed} failed>"
