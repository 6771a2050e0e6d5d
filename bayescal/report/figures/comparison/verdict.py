"""Probability of each order, an axis a panel: the one picture of a report."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bayescal.comparison.evidence import PLAUSIBLE
from bayescal.comparison.results import AxisComparison
from bayescal.report.figures.style import BLUE, PALE, SKY, WIDTH, several_panels
from bayescal.report.figures.subject import Subject
from bayescal.report.typography import typeset
from bayescal.rounding import percent

RECOMMENDED = "recommended"
NOT_EXCLUDED = typeset(f"not excluded at {100 * PLAUSIBLE:.0f}%")
EXCLUDED = "excluded"
COLOURS = {RECOMMENDED: BLUE, NOT_EXCLUDED: SKY, EXCLUDED: PALE}
BESIDE = 8  # orders up to which two panels stand beside each other


def draw(subject: Subject) -> Figure:
    """Draw a bar per order: dark the recommended one, light what else is plausible."""
    axes = subject.axes
    beside = max(len(axis.orders) for axis in axes) <= BESIDE
    shape = (1, len(axes)) if beside else (len(axes), 1)
    figure = several_panels(WIDTH, 2.7 * shape[0] + 0.2)
    shown = set[str]()
    for panel, axis in zip(figure.subplots(*shape, squeeze=False).flat, axes, strict=True):
        if axis.verdict.order is None:
            _draw_bic(panel, axis)
        else:
            shown |= _draw_probability(panel, axis)
        panel.set_xticks([result.order for result in axis.orders])
        panel.set_xlim(axis.orders[0].order - 0.7, axis.orders[-1].order + 0.7)
        panel.set_xlabel(f"order of {axis.data.axis}({axis.data.regressor})")
        panel.tick_params(axis="x", length=0)
    if shown:
        handles = [Patch(color=colour, label=label) for label, colour in COLOURS.items()]
        handles = [handle for handle in handles if handle.get_label() in shown]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _draw_probability(panel: Axes, axis: AxisComparison) -> set[str]:
    """Draw the bars; return what their colours say."""
    shown = set()
    crowded = len(axis.orders) > 2 * BESIDE
    for result in axis.orders:
        chance = result.probability or 0.0
        label = _standing(axis, result.order)
        shown.add(label)
        panel.bar(result.order, 100 * chance, width=0.72, color=COLOURS[label])
        if not crowded or chance >= 0.0005:
            panel.annotate(
                typeset(percent(chance)),
                (result.order, 100 * chance),
                (0, 2),
                textcoords="offset points",
                ha="center",
                fontsize=7 if crowded else 8.5,
            )
    panel.set_ylim(0, 108)
    panel.set_yticks([0, 25, 50, 75, 100])
    panel.set_ylabel("posterior probability [%]")
    panel.set_title(typeset(_headline(axis)), loc="left")
    return shown


def _standing(axis: AxisComparison, order: int) -> str:
    """Say what the verdict holds of an order, in a key of `COLOURS`."""
    if order == axis.verdict.order:
        return RECOMMENDED
    return NOT_EXCLUDED if order in axis.verdict.plausible else EXCLUDED


def _draw_bic(panel: Axes, axis: AxisComparison) -> None:
    """Draw what is left under a flat prior."""
    panel.set_title(f"{axis.data.axis}: a flat prior has no probabilities", loc="left")
    panel.set_ylabel("BIC less the lowest")
    for order, value in _bic(axis).items():
        panel.bar(order, value, width=0.72, color=BLUE if value == 0 else PALE)
        label = f"{value:.1f}"
        panel.annotate(
            label, (order, value), (0, 2), textcoords="offset points", ha="center", fontsize=8.5
        )


def _bic(axis: AxisComparison) -> dict[int, float]:
    """BIC of each order less the lowest; of an exact fit there is none."""
    known = {r.order: r.criteria.bic for r in axis.orders if r.criteria.bic is not None}
    lowest = min(known.values(), default=0.0)
    return {order: value - lowest for order, value in known.items()}


def _headline(axis: AxisComparison) -> str:
    name, verdict = axis.data.axis, axis.verdict
    if len(axis.orders) == 1:
        return f"{name}: only order {verdict.order} was compared"
    order = f"{name}: order {verdict.order}"
    others = ", ".join(map(str, sorted(verdict.plausible[1:])))
    if verdict.decided:
        return f"{order}, decided at {100 * PLAUSIBLE:.0f}%"
    if verdict.outcome == "suffices":
        return f"{order} suffices; {others} not excluded"
    return f"{order}; {others} not excluded" if others else f"{order}, not decided"


def alt_text(subject: Subject) -> str:
    """Say the probabilities, an axis a sentence."""
    return " ".join(_sentence(axis) for axis in subject.axes)


def _sentence(axis: AxisComparison) -> str:
    if axis.verdict.order is None:
        values = ", ".join(f"order {k} {value:.1f}" for k, value in _bic(axis).items())
        shown = f"Bars of BIC less the lowest: {values}." if values else ""
        return f"{axis.data.axis}: a flat prior has no probabilities. {shown}".rstrip()
    chances = ", ".join(f"order {r.order} {percent(r.probability or 0.0)}" for r in axis.orders)
    return f"Bars of the probability of each order. {_headline(axis)}. {chances}."
