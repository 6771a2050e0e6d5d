"""Whether the draws can be trusted."""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.report.blocks import Blocks, Details, Figure, Prose, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell, order_table
from bayescal.report.views.views import Topic
from bayescal.rounding import significant

DPI = 150  # of figures too crowded for lines


def of_axis(comparison: Comparison, axis: AxisComparison) -> Blocks:
    """Show the diagnostics of every order, and the chains of the recommended one."""
    name, order = axis.data.axis, axis.chosen.order
    caption = f"Sampling of every order of {name}; each cell is its worst parameter's."
    autocorrelation = f"Autocorrelation of the chains of {name}, order {order}."
    traces = f"Traces and ranks of the chains of {name}, order {order}."
    trace = Figure("trace", comparison, traces, name, dpi=DPI)
    return (
        Tabled(f"chains-{name}", caption, diagnostics_table(axis)),
        Details(
            f"Traces and autocorrelation of {name}, order {order}",
            (trace, Figure("autocorrelation", comparison, autocorrelation, name)),
        ),
    )


def all_models(comparison: Comparison) -> Blocks:
    """Say how the sampling of all models went."""
    return (Prose(sampling_words(comparison)),)


TOPIC = Topic(
    "chains",
    "Sampling",
    "Every number above rests on draws; these say whether the draws can be trusted.",
    of_axis,
    before=all_models,
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
    ess = min(p.ess for p in parameters)
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


def sampling_words(comparison: Comparison) -> str:
    """Say how the sampling of all models went."""
    results = [r for axis in comparison.axes.values() for r in axis.orders]
    chains = [r.posterior.chain for r in results]
    parameters = [p for r in results for p in r.posterior.parameters]
    ess = min(p.ess for p in parameters)
    return (
        f"emcee, {len(results)} model{'s' * (len(results) > 1)}, seed {comparison.seed}: "
        f"acceptance at least {min(c.acceptance for c in chains):.2f}, autocorrelation time at "
        f"most {max(c.autocorrelation_time for c in chains):.2f} steps, ESS at least {ess:.0f}, "
        f"R-hat at most {max(p.rhat for p in parameters):.3f}; {_checked(results)}."
    )


def _checked(results: Sequence[OrderResult]) -> str:
    """Say what draws and evidences were checked against."""
    deviations = [p.deviation for r in results for p in r.posterior.parameters]
    compared = [d for d in deviations if d is not None]
    if compared:
        return (
            f"means and sds within {max(compared):.1f} Monte Carlo errors of the closed form "
            "(limit 5)"
        )
    errors = [r.posterior.log_evidence_error or 0.0 for r in results]
    return f"evidences to within {significant(max(errors), 1)} nat (limit 0.1)"
