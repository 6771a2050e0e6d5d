"""How the evidence depends on the prior and on the noise assumed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.noise.choice import NOISE_WORDS
from bayescal.report.blocks import Block, Blocks, Figure, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell, order_table
from bayescal.report.views.orders.robust import error_cell
from bayescal.report.views.views import Topic
from bayescal.report.views.words import IN_NUMBERS, MARK, floor_words, one_decimal, shape_words
from bayescal.rounding import significant

if TYPE_CHECKING:  # a comparison without a defence does not pay for it
    from bayescal.comparison.defence.sensitivity import TauSensitivity
    from bayescal.comparison.judged import Weighed

# The table over tau shows the decades of its grid.
ON_DECADE = 1e-9
# Columns of fixed tau that fit a terminal.
MOST_COLUMNS = 7


def of_axis(comparison: Comparison, axis: AxisComparison) -> Blocks:
    """Show the evidence over fixed tau, and under other noise models."""
    defence, name = axis.defence, axis.data.axis
    if defence is None:
        return ()
    blocks: list[Block] = []
    if defence.tau is not None and len(axis) > 1:
        caption = (
            f"Log evidence of each order of {name} were the strength of the non-linearity, "
            "tau, known beforehand; a fraction of the image."
        )
        blocks.append(Figure("evidence", comparison, caption, name))
        blocks.append(
            Tabled(
                f"tau-{name}",
                f"Log evidence of each order of {name} at fixed tau.",
                tau_table(axis, defence.tau),
                folded=IN_NUMBERS,
            )
        )
    if defence.noises:
        caption = f"Evidence of the recommended order of {name} under each noise model."
        table, notes = noises_table(axis, defence.noises), (noises_note(axis, defence.noises),)
        blocks.append(Tabled(f"noises-{name}", caption, table, notes))
    return tuple(blocks)


TOPIC = Topic(
    "evidence",
    "Evidence and its assumptions",
    "Would another prior, or another noise, have chosen another order?",
    of_axis,
)


def tau_table(axis: AxisComparison, found: TauSensitivity) -> Table:
    """Log evidence of every order at a few fixed tau."""
    decades = np.log10(found.tau)
    at = [int(i) for i in np.flatnonzero(np.abs(decades - np.round(decades)) < ON_DECADE)]
    at = at[:: -(-len(at) // MOST_COLUMNS)]
    shown = [significant(100 * float(found.tau[i])) for i in at]
    columns = [Column(f"{share}%") for share in shown]
    rows = [[number_cell(float(row[i]), one_decimal) for i in at] for row in found.log_evidence]
    head = Column(
        "ln Z at fixed tau", "log evidence at these tau, fractions of the image", "order, at tau"
    )
    return order_table(found.orders, columns, rows, axis.verdict.order, head=head)


def noises_note(axis: AxisComparison, noises: tuple[Weighed, ...]) -> str:
    """Say under which priors the other noise models were judged."""
    from bayescal.comparison.defence.other_noise import named

    words = "; ".join(shape_words(named(found.key.noise, axis.data), axis.data) for found in noises)
    same = f"Coefficients and sigma have the priors above.{floor_words(axis.data, axis.noise)}"
    return f"Other noise: {words}. {same}"


def noises_table(axis: AxisComparison, noises: tuple[Weighed, ...]) -> Table:
    """Log evidence of the recommended order under every noise model."""
    chosen = axis.chosen
    own = chosen.log_evidence or 0.0
    rows = [
        (
            Cell(f"{NOISE_WORDS[axis.noise_model.name]}, as compared"),
            Cell(f"{own:.2f}{MARK * bool(chosen.warnings)}", own),
            Cell("") if chosen.posterior.exact is not None else error_cell(chosen),
            Cell(""),
        )
    ]
    for found in noises:
        mark, value = MARK * bool(found.warnings), found.log_evidence or 0.0
        rows.append(
            (
                Cell(NOISE_WORDS[found.key.noise]),
                Cell(f"{value:.2f}{mark}", value),
                number_cell(found.log_evidence_error or None, lambda v: significant(v, 1)),
                Cell(f"{value - own:+.2f}{mark}", value - own),
            )
        )
    columns = (
        Column(f"noise, at order {chosen.order}"),
        Column("ln Z", "natural logarithm of the evidence"),
        Column("MC error", "Monte Carlo standard error of ln Z, nat"),
        Column("ln B", "against the noise compared with"),
    )
    return Table(columns, tuple(rows))
