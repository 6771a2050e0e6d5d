"""What the higher orders do."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Block, Blocks, Details, Figure
from bayescal.report.views.views import Topic


def of_axis(comparison: Comparison, axis: AxisComparison) -> Blocks:
    """Show the fitted curve less its straight part, of the chosen order and the plausible ones."""
    name, chosen = axis.data.axis, axis.chosen.order
    words = (
        f"Fitted curve of {name} at order {chosen}, less its straight part, so that the bend can "
        "be seen: posterior mean with pointwise 95% bands."
    )
    blocks: list[Block] = [Figure("curve", comparison, words, name)]
    for order in axis.verdict.plausible:
        if order != chosen:
            caption = f"The same of order {order}, which is not excluded."
            figure = Figure("curve", comparison, caption, name, order)
            blocks.append(Details(f"Order {order} of {name}", (figure,)))
    return tuple(blocks)


TOPIC = Topic("curve", "Fitted curve", "What the orders above the first add, in pixels.", of_axis)
