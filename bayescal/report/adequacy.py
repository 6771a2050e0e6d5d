"""Adequacy tests of an axis for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table as RichTable

from bayescal.comparison.adequacy.outcome import AdequacyTest
from bayescal.report.grid import Cell, Column, Table, number_cell
from bayescal.report.render import indented


def adequacy_view(tests: Sequence[AdequacyTest], order: int) -> RenderableType:
    """One row per test that applies, the words for concerns, and what was not tested.

    Parameters
    ----------
    tests : sequence of AdequacyTest
        Of one axis.
    order : int
        The order they are of.
    """
    found = adequacy_table(tests, order)
    table = RichTable(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="")
    table.add_column("", no_wrap=True)
    for number, column in enumerate(found.columns):
        table.add_column(column.head, justify="left" if number < 2 else "right", no_wrap=True)
    concerns = [test.concern for test in tests if _applies(test)]
    for concern, row in zip(concerns, found.rows, strict=True):
        mark, style = (" !", "bold") if concern else ("", "")
        table.add_row(mark, *(cell.text for cell in row), style=style)
    lines = [f"! {test.name}: {test.meaning}" for test in tests if test.concern]
    return Group(*([table] if found.rows else []), *indented([*lines, *adequacy_lines(tests)]))


def adequacy_table(tests: Sequence[AdequacyTest], order: int) -> Table:
    """One row per test that applies."""
    columns = (
        Column(f"adequacy of order {order}", "what is tested", f"test of order {order}"),
        Column("statistic"),
        Column("dof", "degrees of freedom"),
        Column("p", "p-value where the model holds and errors are independent"),
        Column("Holm", "p adjusted for the other tests of this block (Holm 1979)", "p, adjusted"),
    )
    rows = tuple(
        (
            Cell(test.name),
            Cell(_statistic(test)),
            Cell("" if test.dof is None else ", ".join(str(d) for d in test.dof)),
            number_cell(test.p_value, _p),
            number_cell(test.p_adjusted, _p),
        )
        for test in tests
        if _applies(test)
    )
    return Table(columns, rows)


def adequacy_lines(tests: Sequence[AdequacyTest]) -> list[str]:
    """Say what to know of the table of tests, and what was not tested."""
    lines = []
    count = sum(test.p_value is not None for test in tests)
    if count:
        lines.append(
            f"Holm: p adjusted for the {count} tests of this block; a concern (!) is below 0.05."
        )
    if any(test.statistic == "ppp" for test in tests):
        lines.append(
            "ppp: share of data sets replicated from the draws with as large a value; not uniform "
            "under the model."
        )
    reasons: dict[str, list[str]] = {}
    for test in tests:
        if not _applies(test):
            reasons.setdefault(test.meaning, []).append(test.name)
    if reasons:
        listed = "; ".join(f"{', '.join(names)} ({why})" for why, names in reasons.items())
        lines.append(f"Not tested: {listed}.")
    return lines


def _applies(test: AdequacyTest) -> bool:
    return test.statistic is not None or test.concern


def _statistic(test: AdequacyTest) -> str:
    if test.statistic is None:
        return ""
    if test.value is None:
        return f"{test.statistic} infinite"
    shown = f"{test.value:.0f}" if test.statistic == "runs" else f"{test.value:.3g}"
    return f"{test.statistic} = {shown}"


def _p(value: float) -> str:
    return "<0.001" if value < 0.001 else f"{value:.3f}"
