"""The evidence of the recommended order under other noise: lines and table."""

from __future__ import annotations

from bayescal.comparison.defence.noise_evidence import NoiseEvidence, in_words, named
from bayescal.comparison.results import AxisComparison
from bayescal.inference.posterior import Posterior
from bayescal.report.grid import Cell, Column, Table, number_cell
from bayescal.report.noise import MARK, floor_words, shape_words
from bayescal.report.robust import error_cell
from bayescal.rounding import significant


def other_noise_lines(axis: AxisComparison, noises: tuple[NoiseEvidence, ...]) -> list[str]:
    """Say under which priors the other noise models were judged."""
    words = "; ".join(shape_words(named(found.name, axis.data), axis.data) for found in noises)
    same = f"Coefficients and sigma have the priors above.{floor_words(axis.data, axis.noise)}"
    return [f"Other noise: {words}. {same}"]


def noises_table(axis: AxisComparison, noises: tuple[NoiseEvidence, ...]) -> Table:
    """Log evidence of the recommended order under every noise model."""
    chosen = axis.chosen
    own = chosen.log_evidence or 0.0
    rows = [
        (
            Cell(f"{in_words(axis.noise_model.name)}, as compared"),
            Cell(f"{own:.2f}{MARK * bool(chosen.evidence_warnings)}", own),
            Cell("") if isinstance(chosen.posterior, Posterior) else error_cell(chosen),
            Cell(""),
        )
    ]
    for found in noises:
        mark = MARK * bool(found.warnings)
        rows.append(
            (
                Cell(in_words(found.name)),
                Cell(f"{found.total:.2f}{mark}", found.total),
                number_cell(found.total_error or None, lambda v: significant(v, 1)),
                Cell(f"{found.total - own:+.2f}{mark}", found.total - own),
            )
        )
    columns = (
        Column(f"noise, at order {chosen.order}"),
        Column("ln Z", "natural logarithm of the evidence"),
        Column("MC error", "Monte Carlo standard error of ln Z, nat"),
        Column("ln B", "against the noise compared with"),
    )
    return Table(columns, tuple(rows))
