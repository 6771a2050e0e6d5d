"""The kinds of finding: one line each, the gravest first among those alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from bayescal.comparison.finding import Finding, ordered
from bayescal.comparison.findings.bounds import at_bounds
from bayescal.comparison.findings.case import Case
from bayescal.comparison.findings.edge import edge
from bayescal.comparison.findings.flattened import flattened
from bayescal.comparison.findings.misfit import misfit
from bayescal.comparison.findings.sampling import sampled, sampling
from bayescal.comparison.findings.surroundings import geometry

KINDS: tuple[Callable[[Case], Iterator[Finding]], ...] = (
    geometry,
    misfit,
    edge,
    at_bounds,
    flattened,
    sampling,
    sampled,
)


def findings(case: Case) -> tuple[Finding, ...]:
    """Look for every kind of finding, the gravest first."""
    return ordered(found for kind in KINDS for found in kind(case))
