"""The posterior of all parameters together."""

from __future__ import annotations

from bayescal.report.page.blocks import Block, Details, Section
from bayescal.report.page.subject import PageSubject

FOLDED_DPI = 100  # of the corner plots that are folded away


def section(subject: PageSubject) -> Section:
    """Show the corner plot of each chosen order; any other folded away."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        name, chosen = axis.data.axis, axis.chosen.order
        caption = (
            f"Draws of {name} at order {chosen} with the closed form laid over them where there "
            "is one. Contours hold 39.3% and 86.5% of a plane's probability: one and two sigma "
            "of a normal in two dimensions."
        )
        blocks: list[Block] = [subject.picture("corner", caption, name)]
        for result in axis.orders:
            if result.order != chosen:
                words = f"The same of order {result.order}."
                picture = subject.picture("corner", words, name, result.order, FOLDED_DPI)
                blocks.append(Details(f"Order {result.order} of {name}", (picture,)))
        parts[name] = tuple(blocks)
    return Section(
        "posterior",
        "Posterior",
        "Coefficients of a power series are strongly correlated; their joint posterior says how.",
        subject.parts(parts),
    )
