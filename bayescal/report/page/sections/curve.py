"""What the higher orders do."""

from __future__ import annotations

from bayescal.report.page.blocks import Block, Details, Section
from bayescal.report.page.subject import PageSubject


def section(subject: PageSubject) -> Section:
    """Show the fitted curve less its straight part, of the chosen order and the plausible ones."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        name, chosen = axis.data.axis, axis.chosen.order
        words = (
            "less its straight part, so that the bend can be seen: posterior mean with "
            "pointwise 95% bands."
        )
        blocks: list[Block] = [
            subject.picture("curve", f"Fitted curve of {name} at order {chosen}, {words}", name)
        ]
        for order in axis.verdict.plausible:
            if order != chosen:
                caption = f"The same of order {order}, which is not excluded."
                picture = subject.picture("curve", caption, name, order)
                blocks.append(Details(f"Order {order} of {name}", (picture,)))
        parts[name] = tuple(blocks)
    return Section(
        "curve",
        "Fitted curve",
        "What the orders above the first add, in pixels.",
        subject.parts(parts),
    )
