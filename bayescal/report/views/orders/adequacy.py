"""Whether the recommended order is good enough, or only the best of those compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Blocks, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.report.views.views import Topic
from bayescal.report.views.words import p_words
from bayescal.rounding import grouped

if TYPE_CHECKING:  # a comparison without a defence does not pay for it
    from bayescal.comparison.adequacy.outcome import AdequacyTest


def of_axis(_: Comparison, axis: AxisComparison) -> Blocks:
    """Show the tests of an axis."""
    if not axis.adequacy:
        return ()
    what = f"order {axis.chosen.order} of {axis.data.axis}"
    return adequacy_blocks(axis.adequacy, axis.data.axis, what, sampled_words(axis))


TOPIC = Topic(
    "adequacy",
    "Adequacy",
    "The most probable order may still miss what the points say; these tests look for it.",
    of_axis,
)


def sampled_words(axis: AxisComparison) -> str:
    """Say of how many points tests and figures are, where these are not all."""
    if axis.data.whole is None:
        return ""
    return f"Tested on {len(axis.data)} of {grouped(axis.data.n)} points drawn at random."


def adequacy_blocks(
    tests: Sequence[AdequacyTest], name: str, what: str, sampled: str = ""
) -> Blocks:
    """One row per test, then what was not tested; what is of concern, the caveats say."""
    flagged = frozenset(i for i, t in enumerate(filter(_applies, tests)) if t.concern)
    return (
        Tabled(
            f"adequacy-{name}",
            f"Adequacy of {what}; concerns are marked.",
            adequacy_table(tests, what),
            (*filter(None, [sampled]), *adequacy_lines(tests)),
            flagged=flagged,
        ),
    )


def adequacy_table(tests: Sequence[AdequacyTest], what: str) -> Table:
    """One row per test that applies."""
    columns = (
        Column(f"adequacy of {what}", "what is tested", f"test of {what}"),
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
            number_cell(test.p_value, p_words),
            number_cell(test.p_adjusted, p_words),
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
            f"Holm: p adjusted for the {count} tests of this block; a concern, which is marked, is "
            "below 0.05; the caveats of the verdict say what it means."
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
