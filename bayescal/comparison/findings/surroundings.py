"""What points and camera, or another model of them, say against a comparison of orders."""

from __future__ import annotations

from collections.abc import Iterator

from bayescal.comparison.finding import Finding, wrong_model
from bayescal.comparison.findings.case import Case


def geometry(case: Case) -> Iterator[Finding]:
    """Pass on what nobody would mean of points and camera."""
    for text in case.geometry:
        yield wrong_model("geometry", text, "the geometry is not what anybody would mean")


def another_model(hint: str) -> Finding:
    """Make the finding that another family or a free position is very strongly better."""
    return wrong_model("another-model", hint, "another model is very strongly better")
