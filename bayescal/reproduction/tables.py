"""What ``reproduce`` prints: sums of squares of the variants, and the elimination."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bayescal.report.blocks import Blocks, Listing, Part, Prose, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell, order_table
from bayescal.reproduction.models import AS_CODED
from bayescal.reproduction.results import AxisReproduction, OrderReproduction, Reproduction
from bayescal.rounding import counted, plain

# Columns for the points removed; the JSON document has them all.
REMOVED_WIDTH = 25


def reproduction_view(reproduction: Reproduction) -> Blocks:
    """Everything that ``reproduce`` prints; the main message comes first."""
    return (
        Listing(_about(reproduction), role="about"),
        _sums(reproduction),
        Listing(tuple(f"{m.name}: {conclusion(m)}" for m in reproduction.models)),
        _elimination(reproduction),
        *(Prose(f"warning: {line}.") for line in reproduction.warnings),
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
        f"BIC is lowest at order {best.order}; {who} {100 * gain:.1f}% more off RSS, chance "
        f"alone {100 * by_chance:.1f}%."
    )


def _span(orders: Sequence[int]) -> str:
    if list(orders) == list(range(orders[0], orders[-1] + 1)):
        return f"{orders[0]}-{orders[-1]}" if len(orders) > 1 else str(orders[0])
    return ", ".join(map(str, orders))


def _about(reproduction: Reproduction) -> tuple[str, ...]:
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
    return tuple(lines)


def _sums(reproduction: Reproduction) -> Tabled:
    """Orders below each other, models beside each other."""
    columns = tuple(
        Column(head)
        for model in reproduction.models
        for head in (f"{model.name.split()[-1]} RSS", "RMS", "LOO", "BIC")
    )
    rows = [
        [cell for m in reproduction.models for cell in _cells(m, m.orders[row])]
        for row in range(len(reproduction.orders))
    ]
    note = (
        "px², px: RMS = sqrt(RSS / n); LOO, the RMS error at each point left out of its own fit. "
        "* lowest BIC"
    )
    table = order_table(reproduction.orders, columns, rows, None, spare=("RMS",))
    return Tabled("sums", "Sums of squares", table, (note,))


def _cells(model: AxisReproduction, order: OrderReproduction) -> Iterator[Cell]:
    """Numbers of one fit; the lowest BIC has a star."""
    fit, star = order.before, "* "[order is not model.best]
    yield Cell(plain(fit.rss), fit.rss)
    yield Cell(plain(fit.rms, 2), fit.rms)
    yield number_cell(fit.fit.rms_left_out, lambda value: plain(value, 2))
    yield number_cell(fit.bic, lambda value: plain(value) + star)


def _elimination(reproduction: Reproduction) -> Part:
    """One row per model and order: which points went, and the fit before and after."""
    common, rule = reproduction.common, reproduction.rule
    heads = ("", "points removed", "left", "RSS before", "RSS after")
    last = ("RSS", "BIC") if common else ("RMS before", "RMS after", "BIC")
    rows = [
        (
            Cell(f"{model.name}, {result.order}"),
            Cell(_removed(result)),
            Cell(str(len(result.after.kept))),
            Cell(plain(result.before.rss)),
            Cell(plain(result.after.rss)),
            *(Cell(text) for text in _last(model, result, common=common)),
        )
        for model in reproduction.models
        for result in model.orders
        if model.variant != AS_CODED or result.before.model.slipped
    ]
    about = (
        "The most significant one at a time, with a refit; "
        f"{100 * rule.significance:g}% {'per point' if rule.per_point else 'family-wise'}, "
        + ("sigma inferred." if rule.sigma is None else f"sigma {rule.sigma:g} px.")
    )
    columns = tuple(Column(head) for head in (*heads, *last))
    table = Table(columns, tuple(rows), spare=("RMS before", "RMS after"))
    notes = tuple(_elimination_notes(reproduction))
    tabled = Tabled("elimination", "Bad points eliminated", table, notes)
    return Part("Bad points eliminated", (Prose(about), tabled))


def _last(model: AxisReproduction, result: OrderReproduction, *, common: bool) -> Iterator[str]:
    """Give what can be compared: on the points that every order keeps, or each on its own."""
    shown = result.common if common else result.after if model.same_points else None
    if common:
        yield plain(result.common.rss) if result.common is not None else ""
    else:
        yield plain(result.before.rms, 2)
        yield plain(result.after.rms, 2)
    yield "" if shown is None or shown.bic is None else plain(shown.bic)


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
