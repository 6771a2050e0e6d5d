"""A comparison as a page: the values, and their HTML."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.results import Comparison
from bayescal.files import write_whole
from bayescal.report.document.comparison import comparison_document
from bayescal.report.document.families import families_document
from bayescal.report.document.outliers import outliers_document
from bayescal.report.page.blocks import Page, Section
from bayescal.report.page.sections import SECTIONS
from bayescal.report.page.sections.bad_points import study_section
from bayescal.report.page.sections.families import families_section
from bayescal.report.page.sections.provenance import of_documents
from bayescal.report.page.subject import PageSubject
from bayescal.report.page.typography import symbol, typeset, visible
from bayescal.report.terminal import header_lines
from bayescal.version import __version__

NOT_SOUND = (
    "Not sound: the draws of some models did not converge or disagree with the closed form. See "
    "Sampling."
)


def page_of(
    comparison: Comparison,
    command: str,
    study: OutlierStudy | None = None,
    progress: Callable[[str], None] | None = None,
    families: FamilyComparison | None = None,
) -> Page:
    """Collect everything that a page shows.

    Parameters
    ----------
    comparison : Comparison
    command : str
        How it was asked for, for the provenance.
    study : OutlierStudy, optional
        The bad points of the same data, shown in a section of their own.
    progress : callable, optional
        Called with a section's name before it is made: drawing takes most of the time.
    families : FamilyComparison, optional
        Families of models of the same points, shown in a section of their own.

    Returns
    -------
    Page
    """
    subject = PageSubject(comparison, comparison_document(comparison, command), study, families)
    found = []
    for section in SECTIONS:
        if progress is not None:
            progress(section.__module__.rpartition(".")[2].replace("_", " "))
        made = section(subject)
        if made is not None:
            found.append(made)
    pairs = [f"{len(subject.axes[0].data)} pairs of x and y"] * (comparison.points is None)
    lines = [*pairs, *header_lines(comparison)]
    origin = subject.document["provenance"]
    return Page(
        title="Which polynomial order? A camera calibration compared"
        if comparison.points is not None
        else "Which polynomial order? A comparison",
        about=tuple(line[0].upper() + line[1:] + "." for line in lines),
        warning="" if comparison.sound else NOT_SOUND,
        sections=tuple(found),
        made_by=f"bayescal {__version__}, {origin['created']}",
    )


def study_page(study: OutlierStudy, command: str) -> Page:
    """Collect what a page of bad points alone shows.

    Parameters
    ----------
    study : OutlierStudy
    command : str
        How it was asked for, for the provenance.

    Returns
    -------
    Page
    """
    kept = outliers_document(study, command)
    return _alone("Bad points of a camera calibration", study, study_section(study), outliers=kept)


def families_page(found: FamilyComparison, command: str) -> Page:
    """Collect what a page of families alone shows.

    Parameters
    ----------
    found : FamilyComparison
    command : str
        How it was asked for, for the provenance.

    Returns
    -------
    Page
    """
    kept = families_document(found, command)
    title = "The order, or the model? Families of camera models compared"
    return _alone(title, found, families_section(found), families=kept)


def _alone(
    title: str,
    found: OutlierStudy | FamilyComparison,
    section: Section,
    **documents: dict[str, Any],
) -> Page:
    """Make a page of one section and of where it comes from."""
    (kept,) = documents.values()
    return Page(
        title=title,
        about=(f"{len(found.points)} points from {found.points.source}.",),
        warning="" if found.sound else "Not sound: an evidence should not be trusted.",
        sections=(section, of_documents(documents)),
        made_by=f"bayescal {__version__}, {kept['provenance']['created']}",
    )


def html(page: Page) -> str:
    """Render a page as one self-contained HTML text; all text is escaped."""
    environment = Environment(
        loader=PackageLoader("bayescal.report.page", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update({"typeset": typeset, "visible": visible, "symbol": symbol})
    folder = files("bayescal.report.page")
    own = {
        name: Markup((folder / file).read_text(encoding="utf-8").strip())
        for name, file in (("style", "style.css"), ("script", "script.js"))
    }
    return environment.get_template("template.html.j2").render(page=page, **own)


def save_report(comparison: Comparison, path: str | Path, *, force: bool = False) -> None:
    """Write a comparison as one self-contained HTML page.

    Parameters
    ----------
    comparison : Comparison
        Sections that need a defence (``defend=True``) are left out where it has none.
    path : str or Path
    force : bool, optional
        Replace an existing file.

    Raises
    ------
    OutputError
        Where the file exists (without `force`) or can't be written.
    """
    made = html(page_of(comparison, "bayescal.save_report"))
    write_whole(Path(path), made.encode(), force=force)
