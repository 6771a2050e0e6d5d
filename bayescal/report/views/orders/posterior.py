"""The posterior of all parameters together."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Block, Blocks, Details, Figure
from bayescal.report.views.orders.chains import DPI
from bayescal.report.views.views import Topic

FOLDED_DPI = 100  # of the corner plots that are folded away


def of_axis(comparison: Comparison, axis: AxisComparison) -> Blocks:
    """Show the corner plot of each chosen order; its nearest plausible rival's folded away."""
    name, chosen = axis.data.axis, axis.chosen.order
    caption = (
        f"Draws of {name} at order {chosen} with the closed form laid over them where there "
        "is one. Contours hold 39.3% and 86.5% of a plane's probability: one and two sigma "
        "of a normal in two dimensions."
    )
    blocks: list[Block] = [Figure("corner", comparison, caption, name, dpi=DPI)]
    for order in [order for order in axis.verdict.plausible if order != chosen][:1]:
        words = f"The same of order {order}."
        figure = Figure("corner", comparison, words, name, order, FOLDED_DPI)
        blocks.append(Details(f"Order {order} of {name}", (figure,)))
    return tuple(blocks)


TOPIC = Topic(
    "posterior",
    "Posterior",
    "Coefficients of a power series are strongly correlated; their joint posterior says how.",
    of_axis,
)
