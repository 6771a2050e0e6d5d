"""A reproduction on disk: a folder with the document and the figures."""

from __future__ import annotations

from pathlib import Path

from bayescal.files import FolderKind, check_folder, write_folder
from bayescal.report.figures.style import save_figure
from bayescal.reproduction.figures import thesis_figures
from bayescal.reproduction.results import Reproduction

DOCUMENT = "reproduction.json"
KIND = FolderKind("reproduction", DOCUMENT, ("figure-*.png", "figure-*.svg"))


def check_reproduction(folder: Path, *, force: bool) -> None:
    """Refuse, before any work is done, a place a reproduction can't be written to.

    Raises
    ------
    OutputError
        As `bayescal.files.check_folder`.
    """
    check_folder(folder, KIND, force=force)


def write_reproduction(
    folder: Path, reproduction: Reproduction, document_json: str, *, force: bool
) -> None:
    """Write a reproduction, whole or not at all.

    Parameters
    ----------
    folder : Path
    reproduction : Reproduction
    document_json : str
        The document.
    force : bool
        Replace an earlier reproduction.

    Raises
    ------
    OutputError
        Where it can't be written; nothing is left behind.
    """

    def fill(made: Path) -> None:
        (made / DOCUMENT).write_text(document_json, encoding="utf-8")
        for name, figure in thesis_figures(reproduction).items():
            save_figure(figure, made / name)

    write_folder(folder, KIND, fill, force=force)
