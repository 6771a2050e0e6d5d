"""Whether other points would have led to the same choice."""

from __future__ import annotations

from bayescal.report.defence import joint_table, stability_table, world_lines
from bayescal.report.page.blocks import Block, Part, Prose, Section, Tabled
from bayescal.report.page.subject import PageSubject


def section(subject: PageSubject) -> Section | None:
    """Show resamples, orders beyond the range and the joint probabilities of both axes."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        defence, name = axis.defence, axis.data.axis
        if defence is None or not defence.resampled:
            continue
        words = f"Share of bootstrap resamples that each order of {name} wins."
        caption = f"Stability of the choice for {name}."
        parts[name] = (
            subject.picture("bootstrap", words, name),
            Tabled(f"stability-{name}", caption, stability_table(axis, defence)),
            *(Prose(line, "note") for line in world_lines(axis)),
        )
    if not parts:
        return None
    return Section(
        "stability",
        "Stability",
        "Would other points, or higher orders, have led to another choice?",
        (*subject.parts(parts), *_joint(subject)),
    )


def _joint(subject: PageSubject) -> tuple[Block, ...]:
    if len(subject.axes) != 2:
        return ()
    table = joint_table(*subject.axes)
    if table is None:
        return ()
    caption = "Posterior probability of each pair of orders; the axes are independent."
    blocks = (subject.picture("joint", caption), Tabled("joint", "The same in numbers.", table))
    return (Part("Both axes together", blocks),)
