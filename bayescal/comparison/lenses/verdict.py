"""The verdict across lens models, in plain words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from bayescal.comparison.verdict import Verdict
from bayescal.rounding import significant

TOLERANCE = 0.1  # px: lenses that differ by less are alike for nearly any use


@dataclass(frozen=True, kw_only=True, repr=False)
class LensVerdict(Verdict):
    """What to conclude of lens models.

    Attributes
    ----------
    best : str
        Name of the most probable lens.
    plausible : tuple of str
        Smallest set of lenses, by falling probability, that reaches 0.95.
    simplest : str
        The one of them with the fewest parameters.
    worth, beyond : float or None
        With 95 % probability predictions of the plausible ones differ by no more than this, px:
        where the points are, and over the whole image; None where there are no others, or they
        can't be compared.
    """

    noun: ClassVar[str] = "lens"
    nouns: ClassVar[str] = "lenses"

    best: str
    plausible: tuple[str, ...]
    simplest: str
    worth: float | None
    beyond: float | None

    @property
    def status(self) -> str:
        """Single, decided, suffices, undecided or, where withheld, best compared."""
        if self.compared == 1:
            return "single"
        if self.withheld:
            return "best compared"
        if len(self.plausible) == 1:
            return "decided"
        return "suffices" if self.enough else "undecided"

    @property
    def decided(self) -> bool:
        """Whether one lens of several alone is plausible, and nothing stands against that."""
        return self.status == "decided"

    @property
    def enough(self) -> bool:
        """Whether the plausible lenses predict the same where there are points."""
        return self.worth is not None and self.worth <= TOLERANCE

    @property
    def recommended(self) -> str:
        """Name the most probable lens."""
        return self.best

    @property
    def subject(self) -> str:
        """The most probable lens, written as it is named."""
        return self.best

    def _open(self, lead: str, open_: str) -> str:
        if self.enough:
            return f"{lead}; {open_}, but {self._apart}: {self.simplest} suffices there"
        return f"{lead}; undecided, and it matters: {open_}, and {self._apart}"

    @property
    def _apart(self) -> str:
        """How far predictions of the plausible lenses are apart."""
        if self.worth is None:
            return "how far predictions differ where there are points can't be told"
        size, limit = f"{significant(self.worth)} px", f"the tolerance of {TOLERANCE:g} px"
        if self.enough:
            least = f"predictions differ by at most {size} where there are points (95%)"
            return f"{least}, within {limit}"
        return f"predictions may differ by {size} where there are points (95%), above {limit}"
