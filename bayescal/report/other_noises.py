"""The evidence of the recommended order under other noise: lines and table."""

from __future__ import annotations

from bayescal.comparison.defence.other_noise import named
from bayescal.comparison.judged import Judged
from bayescal.comparison.results import AxisComparison
from bayescal.noise.choice import NOISE_WORDS
from bayescal.report.grid import Cell, Column, Table, number_cell
from bayescal.report.noise import MARK, floor_words, shape_words
from bayescal.report.robust import error_cell
from bayescal.rounding import significant


def other_noise_lines(axis: AxisComparison, noises: tuple[Judged, ...]) -> list[str]:
    """Say under which priors the other noise models were judged."""
    words = "; ".join(shape_words(named(found.key.noise, axis.data), axis.data) for found in noises)
    same = f"Coefficients and sigma have the priors above.{floor_words(axis.data, axis.noise)}"
    return [f"Other noise: {words}. {same}"]


def noises_table(axis: AxisComparison, noises: tuple[Judged, ...]) -> Table:
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
