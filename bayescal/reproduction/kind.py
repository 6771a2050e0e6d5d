"""A reproduction as a kind of result: a folder with the document and the figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bayescal.files import FolderKind
from bayescal.report.blocks import Blocks
from bayescal.report.figures.style import save_figure
from bayescal.report.run.kind import Kind
from bayescal.reproduction.document import reproduction_document
from bayescal.reproduction.figures import thesis_figures
from bayescal.reproduction.results import Reproduction
from bayescal.reproduction.tables import reproduction_view

FOLDER = FolderKind("reproduction", "reproduction.json", ("figure-*.png", "figure-*.svg"))


class ReproductionKind(Kind[Reproduction]):
    """The thesis's own procedure, which takes no time to do again."""

    folder = FOLDER

    def document(self, result: Reproduction, command: str) -> dict[str, Any]:
        """Build its document."""
        return reproduction_document(result, command)

    def view(self, result: Reproduction, *, full: bool = False) -> Blocks:  # noqa: ARG002
        """Give what its command prints, which is everything."""
        return reproduction_view(result)

    def fill(self, folder: Path, result: Reproduction) -> None:
        """Draw the figures."""
        for name, figure in thesis_figures(result).items():
            save_figure(figure, folder / name)


REPRODUCTION = ReproductionKind()
