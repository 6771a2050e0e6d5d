"""Whether the draws can be trusted."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.report.grid import Cell, Column, Table, number_cell, order_table
from bayescal.report.page.blocks import Block, Details, Prose, Section, Tabled
from bayescal.report.page.subject import PageSubject
from bayescal.report.terminal import sampling_words


def section(subject: PageSubject) -> Section:
    """Show the diagnostics of every model, and the chains of the recommended ones."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        name, order = axis.data.axis, axis.chosen.order
        caption = f"Sampling of every order of {name}; each cell is its worst parameter's."
        autocorrelation = subject.picture(
            "autocorrelation", f"Autocorrelation of the chains of {name}, order {order}.", name
        )
        trace = subject.picture(
            "trace", f"Traces and ranks of the chains of {name}, order {order}.", name
        )
        parts[name] = (
            Tabled(f"chains-{name}", caption, diagnostics_table(axis)),
            autocorrelation,
            Details(f"Traces of {name}, order {order}", (trace,)),
        )
    return Section(
        "chains",
        "Sampling",
        "Every number above rests on draws; these say whether the draws can be trusted.",
        (Prose(sampling_words(subject.comparison)), *subject.parts(parts)),
    )


def diagnostics_table(axis: AxisComparison) -> Table:
    """One row per order: how its sampling went."""
    columns = (
        Column("draws"),
        Column("acceptance", "share of proposals accepted"),
        Column("autocorr.", "integrated autocorrelation time, steps; 1 is independence"),
        Column("ESS", "smallest effective sample size, of bulk and tail"),
        Column("R-hat", "largest rank-normalised split R-hat; below 1.01 is converged"),
        Column("off by", "largest distance from the closed form, Monte Carlo errors; limit 5"),
        Column("sound", "converged, and at one with the closed form"),
    )
    return order_table(
        [r.order for r in axis.orders],
        columns,
        [_row(result) for result in axis.orders],
        axis.verdict.order,
    )


def _row(result: OrderResult) -> list[Cell]:
    chain, parameters = result.posterior.chain, result.posterior.parameters
    draws = chain.draws.shape[0] * chain.draws.shape[1]
    ess = min(min(p.ess_bulk, p.ess_tail) for p in parameters)
    rhat = max(p.rhat for p in parameters)
    off = max((p.deviation for p in parameters if p.deviation is not None), default=None)
    return [
        Cell(str(draws), draws),
        Cell(f"{chain.acceptance:.2f}", chain.acceptance),
        Cell(f"{chain.autocorrelation_time:.2f}", chain.autocorrelation_time),
        Cell(f"{ess:.0f}", ess),
        Cell(f"{rhat:.3f}", rhat),
        number_cell(off, lambda v: f"{v:.1f}"),
        Cell("yes" if result.sound else "no", float(result.sound)),
    ]
