"""Log evidence of every lens."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.style import BLUE, PALE, VERMILLION, WIDTH, one_panel, settle

FAR = 300.0  # nat: lenses further below the best are not drawn


def draw(found: LensComparison) -> Figure:
    """Draw a bar for every lens within reach, below the best one."""
    lenses = [j for j in found.lenses if below(found, j.log_evidence) < FAR]
    gaps = [below(found, j.log_evidence) for j in lenses]
    figure, panel = one_panel(WIDTH, 0.9 + 0.27 * len(lenses))
    colours = [BLUE if j.name in found.verdict.plausible else PALE for j in lenses]
    panel.barh(range(len(lenses)), [gap + 0.02 for gap in gaps], color=colours, height=0.7)
    panel.set_yticks(range(len(lenses)), [j.name for j in lenses])
    panel.invert_yaxis()
    panel.set_xscale("symlog", linthresh=1, linscale=0.6)
    panel.set_xlim(0, max([*gaps, 10]) * 1.2)
    panel.axvline(math.log(20), color=VERMILLION, linewidth=1, linestyle="--")
    panel.set_xlabel("ln evidence below the best [nat]; dashed: odds of 20 to 1")
    settle(figure)
    return figure


def below(found: LensComparison, log_evidence: float) -> float:
    """Give how far below the best lens's a log evidence is, nat."""
    return found.best.log_evidence - log_evidence


def alt_text(found: LensComparison) -> str:
    """Say how far below the best the next lenses are."""
    rest = ", ".join(f"{j.name} {below(found, j.log_evidence):.1f}" for j in found.lenses[1:5])
    return f"Log evidence below that of {found.best.name}, nat: {rest or 'no other lens'}."
