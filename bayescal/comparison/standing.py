"""How the most probable of several models stands, in a few words."""

from __future__ import annotations

from bayescal.comparison.conclusion import Verdict
from bayescal.comparison.verdict import percent
from bayescal.rounding import counted

DECIDED = "decided at 95%"


def standing_among(verdict: Verdict, compared: int) -> str:
    """Say how probable it is among so many, and what keeps it from being decided."""
    if compared == 1:
        return "; ".join(("the only one compared", *verdict.withheld[:1]))
    chance, others = f"{percent(verdict.chances[0])} probable", len(verdict.plausible) - 1
    if verdict.withheld:
        return f"{chance} among those compared; not decided: {verdict.withheld[0]}"
    return f"{chance}; " + (f"{counted(others, 'other')} not excluded" if others else DECIDED)
