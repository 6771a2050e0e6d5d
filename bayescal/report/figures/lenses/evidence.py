"""Log evidence over the order, a line per family of lenses."""

from __future__ import annotations

import math

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bayescal.comparison.lenses.results import JudgedLens, LensComparison
from bayescal.report.figures.lenses.models import below
from bayescal.report.figures.style import CYCLE, GREY, VERMILLION, WIDTH, one_panel, settle


def draw(found: LensComparison) -> Figure:
    """Draw each family's evidence over the number of radial coefficients; the others beside."""
    figure, panel = one_panel(WIDTH, 3.6)
    ordered, others = families(found)
    highest = max([j.candidate.order or 0 for line in ordered.values() for j in line], default=0)
    for colour, (name, line) in zip(CYCLE, ordered.items(), strict=False):
        x = [j.candidate.order or 0 for j in line]
        y = [below(found, j.log_evidence) for j in line]
        panel.plot(x, y, "o-", color=colour, label=name, markersize=5, linewidth=1.4)
    for place, judged in enumerate(others, 1):
        at = highest + place
        panel.plot(at, below(found, judged.log_evidence), "D", color=GREY, markersize=5)
    panel.set_yscale("symlog", linthresh=1, linscale=0.6)
    worst = max([below(found, j.log_evidence) for j in found.lenses] + [10])
    panel.set_ylim(worst * 1.3, -0.3)
    panel.axhline(math.log(20), color=VERMILLION, linewidth=1, linestyle="--")
    if others:
        panel.set_xticks(
            [*range(highest + 1), *range(highest + 1, highest + 1 + len(others))],
            [*map(str, range(highest + 1)), *(j.name for j in others)],
        )
    else:
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
    panel.set_xlabel("radial coefficients" + ("; lenses of one order alone" if others else ""))
    panel.set_ylabel("ln evidence below the best [nat]")
    if len(ordered) > 1:
        panel.legend(loc="best")
    settle(figure)
    return figure


def families(found: LensComparison) -> tuple[dict[str, list[JudgedLens]], list[JudgedLens]]:
    """Lenses that have an order, by what they are else, in order; and the others."""
    ordered: dict[str, list[JudgedLens]] = {}
    others = []
    for judged in found.lenses:
        candidate = judged.candidate
        if candidate.order is None or candidate.family not in ("radial", "fisheye"):
            others.append(judged)
            continue
        tangential = " + p" if candidate.name.endswith("+ p") else ""
        ordered.setdefault(f"{candidate.family}{tangential}", []).append(judged)
    if {"radial", "radial + p"} <= set(ordered):  # without coefficients they are one
        ordered["radial + p"] += [j for j in ordered["radial"] if j.candidate.order == 0]
    for line in ordered.values():
        line.sort(key=lambda j: j.candidate.order or 0)
    return dict(sorted(ordered.items())), others


def alt_text(found: LensComparison) -> str:
    """Say at which order each family is best, and how far below the best lens."""
    ordered, others = families(found)
    best = {name: max(line, key=lambda j: j.log_evidence) for name, line in ordered.items()}
    parts = [
        f"{name} is best at order {j.candidate.order}, {below(found, j.log_evidence):.1f} nat below"
        for name, j in best.items()
    ]
    parts += [f"{j.name} {below(found, j.log_evidence):.1f} below" for j in others]
    return f"Log evidence over the order, against {found.best.name}: {'; '.join(parts)}."
