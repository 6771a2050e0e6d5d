"""Orders beyond the range: whether up to three of them would take the winner's place."""

from __future__ import annotations

from collections.abc import Iterator

from bayescal.comparison.finding import Finding, overturns
from bayescal.comparison.findings.beyond_range import beyond_range
from bayescal.comparison.findings.case import Case
from bayescal.comparison.orders.beyond import beyond, orders_beyond

# Of a winner beyond which nobody has looked: the defence looks, and its finding stands instead.
UNSEEN = "edge: unseen"


def edge(case: Case) -> Iterator[Finding]:
    """Look beyond the range, or above the one order fitted, in closed form where there is one.

    Of one order fitted it is not said how sure it is: there only a higher one that wins matters.
    """
    evidence = {r.order: r.log_evidence for r in case.results if r.log_evidence is not None}
    if not evidence:
        return
    axis, highest = case.axis, case.results[-1].order
    at_edge = len(evidence) > 1 and case.best.order == highest
    if case.gaussian:
        found = beyond(axis.data, evidence, axis.noise, axis.rule)
        yield from beyond_range(found, at_edge=at_edge)
    elif at_edge and orders_beyond(axis.data, highest, axis.rule)[0]:
        yield overturns(
            UNSEEN,
            f"order {highest} is the highest compared, and under this noise only "
            "--defend looks beyond it: compare more orders",
            "higher orders were not compared",
        )
