"""Adequacy tests of an axis for a terminal and for the result document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich import box
from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from bayescal.comparison.adequacy.outcome import AdequacyTest


def adequacy_view(tests: Sequence[AdequacyTest], order: int) -> RenderableType:
    """One row per test that applies, the words for concerns, and what was not tested.

    Parameters
    ----------
    tests : sequence of AdequacyTest
        Of one axis.
    order : int
        The order they are of.
    """
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="")
    table.add_column("", no_wrap=True)
    table.add_column(f"adequacy of order {order}", no_wrap=True)
    table.add_column("statistic", no_wrap=True)
    for name in ("dof", "p", "Holm"):
        table.add_column(name, justify="right", no_wrap=True)
    applied = [test for test in tests if _applies(test)]
    for test in applied:
        table.add_row(
            " !" if test.concern else "",
            test.name,
            _statistic(test),
            "" if test.dof is None else ", ".join(str(d) for d in test.dof),
            _p(test.p_value),
            _p(test.p_adjusted),
            style="bold" if test.concern else "",
        )
    count = sum(test.p_value is not None for test in tests)
    lines = [f"! {test.name}: {test.meaning}" for test in applied if test.concern]
    if count:
        lines.append(
            f"Holm: p adjusted for the {count} tests of this block; a concern (!) is below 0.05."
        )
    if any(test.statistic == "ppp" for test in applied):
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
    words = [Padding(Text(line), (0, 0, 0, 2)) for line in lines]
    return Group(*([table] if applied else []), *words)


def adequacy_rows(tests: Sequence[AdequacyTest]) -> list[dict[str, Any]]:
    """Give tests as JSON values: what can't be had is None, never NaN."""
    return [
        {
            "name": test.name,
            "statistic": test.statistic,
            "value": test.value,
            "dof": None if test.dof is None else list(test.dof),
            "p_value": test.p_value,
            "p_adjusted": test.p_adjusted,
            "concern": test.concern,
            "meaning": test.meaning,
            "parts": adequacy_rows(test.parts),
        }
        for test in tests
    ]


def _applies(test: AdequacyTest) -> bool:
    return test.statistic is not None or test.concern


def _statistic(test: AdequacyTest) -> str:
    if test.statistic is None:
        return ""
    if test.value is None:
        return f"{test.statistic} infinite"
    shown = f"{test.value:.0f}" if test.statistic == "runs" else f"{test.value:.3g}"
    return f"{test.statistic} = {shown}"


def _p(value: float | None) -> str:
    if value is None:
        return ""
    return "<0.001" if value < 0.001 else f"{value:.3f}"
