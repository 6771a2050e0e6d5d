"""Orders beyond the range: whether up to three of them would take the winner's place."""

from __future__ import annotations

from collections.abc import Iterator

from bayescal.comparison.finding import Finding
from bayescal.comparison.findings.beyond_range import beyond_range
from bayescal.comparison.findings.case import Case
from bayescal.comparison.orders.beyond import beyond


def edge(case: Case) -> Iterator[Finding]:
    """Look beyond the range, or above the one order fitted, in closed form.

    Of one order fitted it is not said how sure it is: there only a higher one that wins matters.
    """
    evidence = {r.order: r.log_evidence for r in case.results if r.log_evidence is not None}
    if not case.gaussian or not evidence:
        return
    axis = case.axis
    found = beyond(axis.data, evidence, axis.noise, axis.rule)
    at_edge = len(evidence) > 1 and case.best.order == case.results[-1].order
    yield from beyond_range(found, at_edge=at_edge)
