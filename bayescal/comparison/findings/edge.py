"""A winner at the edge of the range: whether up to three orders beyond would take its place."""

from __future__ import annotations

from collections.abc import Iterator

from bayescal.comparison.defence.stability import beyond
from bayescal.comparison.findings.beyond_range import beyond_range
from bayescal.comparison.findings.case import Case
from bayescal.comparison.findings.finding import Finding


def edge(case: Case) -> Iterator[Finding]:
    """Look beyond the range where its highest order is the most probable, in closed form."""
    evidence = {r.order: r.log_evidence for r in case.results if r.log_evidence is not None}
    highest = case.results[-1].order
    if not case.gaussian or len(evidence) < 2 or case.best.order != highest:
        return
    axis = case.axis
    found = beyond(axis.data, evidence, axis.noise, axis.rule)
    yield from beyond_range(found)
