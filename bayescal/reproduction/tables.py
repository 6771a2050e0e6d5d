"""What ``reproduce`` prints: sums of squares of the variants, and the elimination."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from bayescal.reproduction.models import AS_CODED
from bayescal.reproduction.results import (
    AxisReproduction,
    OrderReproduction,
    Reproduction,
    ThesisFit,
)
from bayescal.rounding import counted, plain

# Columns for the points removed; the JSON document has them all.
REMOVED_WIDTH = 25


def reproduction_view(reproduction: Reproduction) -> RenderableType:
    """Everything that ``reproduce`` prints; the main message comes first, in one screen."""
    return Group(
        _header(reproduction),
        _sums(reproduction),
        *(_indented(f"{model.name}: {conclusion(model)}") for model in reproduction.models),
        Text(""),
        _elimination_header(reproduction),
        Text(""),
        _elimination(reproduction),
        *(_indented(f"warning: {line}.") for line in reproduction.warnings),
    )


def conclusion(model: AxisReproduction) -> str:
    """Say where BIC stops, and whether chance explains what the orders beyond gain.

    Returns
    -------
    str
        One sentence.
    """
    best, last = model.best, model.orders[-1]
    if best is None:
        return "an order fits exactly, so that BIC can't choose."
    if len(model.orders) == 1:
        return f"order {best.order} is the only one fitted."
    if best.order == last.order:
        return f"BIC is lowest at order {best.order}, the highest fitted."
    gain, by_chance = model.gain_beyond(best.order)
    beyond = [o.order for o in model.orders if o.order > best.order]
    who = f"order {beyond[0]} takes" if len(beyond) == 1 else f"orders {_span(beyond)} take"
    return (
        f"BIC is lowest at order {best.order}; {who} {100 * gain:.1f} % more off RSS, chance "
        f"alone {100 * by_chance:.1f} %."
    )


def _span(orders: Sequence[int]) -> str:
    if list(orders) == list(range(orders[0], orders[-1] + 1)):
        return f"{orders[0]}-{orders[-1]}" if len(orders) > 1 else str(orders[0])
    return ", ".join(map(str, orders))


def _header(reproduction: Reproduction) -> RenderableType:
    points = reproduction.points
    x, y, z = points.setup.position
    counted = f"{points.setup.height:g} - row" if points.setup.c_from_bottom else "row"
    lines = [
        f"Least squares of the thesis on {len(points)} points from {points.source}; camera at "
        f"({x:g}, {y:g}, {z:g}), c = {counted}",
        "as written: r in powers of x/z, c in powers of y/z (eq. 33-53)",
    ]
    if any(model.variant == AS_CODED for model in reproduction.models):
        lines.append("as coded: the third and higher powers of r are of y/z (Appendix B)")
    return Text("\n".join(lines) + "\n")


def _sums(reproduction: Reproduction) -> RenderableType:
    """Orders beside each other: one block of columns per model."""
    order = _table("order")
    for k in reproduction.orders:
        order.add_row(str(k))
    titles, tables = [Text("")], [order]
    for model in reproduction.models:
        table = _table("RSS px²", "RMS", "LOO", "BIC")
        for result in model.orders:
            chosen = result is model.best
            table.add_row(*_numbers(result.before, chosen), style="bold" if chosen else "")
        titles.append(Text(model.name, style="bold"))
        tables.append(table)
    grid = Table.grid(padding=(0, 1, 0, 0))
    grid.add_row(*titles)
    grid.add_row(*tables)
    note = (
        "px: RMS = sqrt(RSS / n); LOO, the RMS error at each point left out of its own fit. "
        "* lowest BIC"
    )
    return Group(grid, Text(""), _indented(note), Text(""))


def _numbers(fit: ThesisFit, chosen: bool) -> list[str]:
    left_out = fit.fit.rms_left_out
    return [
        plain(fit.rss),
        plain(fit.rms, 2),
        "" if left_out is None else plain(left_out, 2),
        "" if fit.bic is None else plain(fit.bic) + "* "[not chosen],
    ]


def _elimination_header(reproduction: Reproduction) -> RenderableType:
    rule = reproduction.rule
    text = Text("Bad points eliminated", style="bold")
    text.append(
        f", the most significant at a time, with a refit; {100 * rule.significance:g} % "
        + ("per point" if rule.per_point else "family-wise")
        + (", sigma inferred" if rule.sigma is None else f", sigma {rule.sigma:g} px"),
        style="not bold",
    )
    return text


def _elimination(reproduction: Reproduction) -> RenderableType:
    """One row per model and order: which points went, and the fit before and after."""
    common = reproduction.common
    table = _table("", "order", "points removed, in turn", "left", "RSS px² before > after")
    table.columns[0].justify = table.columns[2].justify = "left"
    for name in ("RSS px²", "BIC") if common else ("RMS px", "BIC"):
        table.add_column(name, justify="right", no_wrap=True)
    for model in reproduction.models:
        title = model.name
        for result in model.orders:
            if model.variant == AS_CODED and not result.before.model.slipped:
                continue
            shown = result.common if common else result.after if model.same_points else None
            bic = "" if shown is None or shown.bic is None else plain(shown.bic)
            before, after = result.before, result.after
            if common:
                sums = plain(result.common.rss) if result.common is not None else ""
            else:
                sums = f"{plain(before.rms, 2)} > {plain(after.rms, 2)}"
            table.add_row(
                title,
                str(result.order),
                _removed(result),
                str(len(after.kept)),
                f"{plain(before.rss)} > {plain(after.rss):>6}",
                sums,
                bic,
            )
            title = ""
    return Group(table, Text(""), *(_indented(line) for line in _elimination_notes(reproduction)))


def _elimination_notes(reproduction: Reproduction) -> list[str]:
    notes = []
    if reproduction.common:
        notes.append("The last two columns are of the points that every order keeps.")
        for model in reproduction.models:
            best = model.best_on_common
            where = "can't choose" if best is None else f"is lowest at order {best.order}"
            notes.append(f"{model.name}, on these {len(model.common_kept)} points: BIC {where}.")
    for model in reproduction.models:
        same = [o.order for o in model.orders if not o.before.model.slipped]
        if model.variant == AS_CODED and same:
            notes.append(f"r as coded is r as written up to order {same[-1]}.")
    return notes


def _removed(result: OrderReproduction) -> str:
    """Name the points removed, in turn, as many as fit the column."""
    numbers = [str(point + 1) for point in result.rejection.removed]
    for named in range(len(numbers), 0, -1):
        rest = len(numbers) - named
        text = " ".join(numbers[:named]) + (f" and {rest} more" if rest else "")
        if len(text) <= REMOVED_WIDTH:
            return text
    return counted(len(numbers), "point") if numbers else "none"


def _table(*names: str) -> Table:
    table = Table(
        box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, header_style=""
    )
    for name in names:
        table.add_column(name, justify="right", no_wrap=True)
    return table


def _indented(line: str) -> RenderableType:
    return Padding(Text(line), (0, 0, 0, 2))
