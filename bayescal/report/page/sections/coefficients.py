"""The numbers to calibrate with."""

from __future__ import annotations

from bayescal.report.page.blocks import Block, Details, Section, Tabled
from bayescal.report.page.subject import PageSubject
from bayescal.report.tables import coefficients_table, exact_table


def section(subject: PageSubject) -> Section:
    """Show the coefficients of the recommended order; any other folded away."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        name, chosen = axis.data.axis, axis.chosen
        symbol, regressor = axis.data.symbol, axis.data.regressor
        caption = (
            f"Coefficients {symbol} of {name} at order {chosen.order}: {symbol}_j multiplies "
            f"({regressor}) to the power j."
        )
        main = Tabled(f"coefficients-{name}", caption, coefficients_table(axis, chosen))
        blocks: list[Block] = [main]
        exact = exact_table(axis, chosen)
        if exact.rows:
            table = Tabled(f"exact-{name}", "Least squares and closed form.", exact)
            blocks.append(Details("Without sampling, as a check", (table,)))
        for result in axis.orders:
            if result is chosen:
                continue
            found = coefficients_table(axis, result)
            caption = f"Coefficients of {name} at order {result.order}."
            table = Tabled(f"coefficients-{name}-{result.order}", caption, found)
            blocks.append(Details(f"Order {result.order} of {name}", (table,)))
        parts[name] = tuple(blocks)
    return Section(
        "coefficients",
        "Coefficients",
        "Uncertainties carry two significant digits (JCGM 100:2008, 7.2.6); intervals are "
        "central and hold 95% of the posterior.",
        subject.parts(parts),
    )
