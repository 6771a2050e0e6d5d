"""Whether the recommended order is good enough, or only the best of those compared."""

from __future__ import annotations

from bayescal.report.adequacy import adequacy_lines, adequacy_table
from bayescal.report.page.blocks import Block, Listing, Section, Tabled
from bayescal.report.page.subject import PageSubject


def section(subject: PageSubject) -> Section | None:
    """Show the block of tests of each axis, with what its concerns mean."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        if not axis.adequacy:
            continue
        name, order = axis.data.axis, axis.chosen.order
        table = adequacy_table(axis.adequacy, order)
        worrying = {test.name for test in axis.adequacy if test.concern}
        flagged = {row for row, cells in enumerate(table.rows) if cells[0].text in worrying}
        parts[name] = (
            Listing(tuple(f"{t.name}: {t.meaning}" for t in axis.adequacy if t.concern), "caveat"),
            Tabled(
                f"adequacy-{name}",
                f"Adequacy of order {order} of {name}; concerns are marked.",
                table,
                tuple(adequacy_lines(axis.adequacy)),
                frozenset(flagged),
            ),
        )
    if not parts:
        return None
    return Section(
        "adequacy",
        "Adequacy",
        "The most probable order may still miss what the points say; these tests look for it.",
        subject.parts(parts),
    )
