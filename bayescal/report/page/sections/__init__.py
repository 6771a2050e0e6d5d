"""The sections of a page, in reading order: one module each, one line each below."""

from __future__ import annotations

from collections.abc import Callable

from bayescal.report.page.blocks import Section
from bayescal.report.page.sections import (
    adequacy,
    bad_points,
    chains,
    coefficients,
    curve,
    evidence,
    families,
    methods,
    orders,
    posterior,
    prediction,
    provenance,
    residuals,
    stability,
    verdict,
)
from bayescal.report.page.subject import PageSubject

# Each gives its section, or None where the comparison has nothing to show in it.
SECTIONS: tuple[Callable[[PageSubject], Section | None], ...] = (
    verdict.section,
    orders.section,
    evidence.section,
    prediction.section,
    stability.section,
    adequacy.section,
    families.section,
    bad_points.section,
    residuals.section,
    curve.section,
    coefficients.section,
    posterior.section,
    chains.section,
    methods.section,
    provenance.section,
)
