"""A comparison of lens models over many views as a kind of result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.document.lenses import lenses_document
from bayescal.report.run.kind import Kind


class LensesKind(Kind[LensComparison]):
    """Which lens model many views support."""

    def document(self, result: LensComparison, command: str) -> dict[str, Any]:
        """Build its document."""
        return lenses_document(result, command)

    def fill(self, folder: Path, result: LensComparison) -> None:
        """Write what belongs beside the document: nothing yet."""


LENSES = LensesKind()
