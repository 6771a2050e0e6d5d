"""The orders beside each other, with every criterion."""

from __future__ import annotations

from bayescal.report.page.blocks import Facts, Section, Tabled
from bayescal.report.page.subject import PageSubject
from bayescal.report.tables import orders_table
from bayescal.report.terminal import footnotes, noise_words, prior_words


def section(subject: PageSubject) -> Section:
    """Show one table per axis, with the assumptions it rests on."""
    parts = {}
    for axis in subject.axes:
        name, domain = axis.data.axis, axis.data.domain
        assumed = (
            ("noise", noise_words(axis)),
            ("prior", prior_words(axis)),
            ("domain", f"{axis.data.regressor} from {domain.lower:.3g} to {domain.upper:.3g}"),
        )
        caption = f"Orders of {name} compared; the recommended one is marked."
        table = Tabled(f"orders-{name}", caption, orders_table(axis), tuple(footnotes(axis)))
        parts[name] = (Facts(assumed), table)
    return Section(
        "orders",
        "The orders compared",
        "Each order is a model of the same pixels; every column judges it differently.",
        subject.parts(parts),
    )
