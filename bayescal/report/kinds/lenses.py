"""A comparison of lens models over many views as a kind of result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.blocks import Blocks
from bayescal.report.document.lenses import lenses_document
from bayescal.report.run.camera import CAMERA, camera_bytes_of
from bayescal.report.run.kind import Kind
from bayescal.report.views.lenses import brief


class LensesKind(Kind[LensComparison]):
    """Which lens model many views support."""

    def document(self, result: LensComparison, command: str) -> dict[str, Any]:
        """Build its document."""
        return lenses_document(result, command)

    def view(self, result: LensComparison, *, full: bool = False) -> Blocks:  # noqa: ARG002
        """Give what its command prints, which is everything."""
        return brief(result)

    def fill(self, folder: Path, result: LensComparison) -> None:
        """Write the camera beside the document."""
        camera = camera_bytes_of(result)
        if camera is not None:
            (folder / CAMERA).write_bytes(camera)


LENSES = LensesKind()
