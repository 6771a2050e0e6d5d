"""A result as a page: its chapters, and their HTML."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bayescal.files import write_whole
from bayescal.points.heading import SILENT, Heading
from bayescal.report.blocks import Prose, Section
from bayescal.report.document.shared import stated_heading
from bayescal.report.page.numbering import numbered
from bayescal.report.page.pictures import drawn
from bayescal.report.runs import kind_of
from bayescal.report.typography import sentence, symbol, typeset, visible
from bayescal.report.views import provenance
from bayescal.version import __version__


@dataclass(frozen=True)
class Page:
    """Everything that the template needs.

    Attributes
    ----------
    about : tuple of str
        What was analysed, a line each.
    warning : str
        Why the whole must not be trusted; empty where it can.
    created : str
        When the analysis was made, ISO 8601.
    heading : Heading
    """

    title: str
    about: tuple[str, ...]
    warning: str
    sections: tuple[Section, ...]
    created: str
    heading: Heading = SILENT

    @property
    def made_by(self) -> str:
        """The program, and when."""
        return f"bayescal {__version__}, {self.created}"

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """What stands in the title block beside the title."""
        said, made = self.heading, datetime.fromisoformat(self.created)
        pairs = (
            ("Camera", said.camera),
            ("Serial number", said.serial),
            ("Operator", said.operator),
            ("Date", f"{made:%Y-%m-%d %H:%M} UTC"),
            ("Program", f"bayescal {__version__}"),
        )
        return tuple((name, value) for name, value in pairs if value)


def page_of(
    result: Any,
    command: str,
    *beside: Any,
    heading: Heading = SILENT,
    progress: Callable[[str], None] | None = None,
) -> Page:
    """Collect everything that a page shows.

    Parameters
    ----------
    command : str
        How it was asked for, for the provenance.
    *beside : FamilyComparison or OutlierStudy
        Results on the same points, shown in chapters of their own.
    heading : Heading, optional
        What the title block says, before what the result itself says.
    progress : callable, optional
        Called with a chapter's name before it is made: drawing takes most of the time.
    """
    kind, views = kind_of(result), kind_of(result).views
    document = kind.document(result, command)
    origin = document["provenance"]
    heading = heading.over(stated_heading(document))
    documents = {kind.element: {**document, "report": heading.facts}}
    for other in beside:
        found = kind_of(other)
        documents[found.element] = found.document(other, origin["command"])
    sections: list[Section] = []
    for name, make in chapters(result, *beside):
        if progress is not None:
            progress(name)
        section = make()
        if section is not None:
            if not sections:
                section = _with_headlines(section, beside)
            sections.append(replace(section, blocks=drawn(section.blocks)))
    if views.methods is not None:
        said = [line for other in beside for line in kind_of(other).views.beside(other)]
        sections.append(views.methods(result, said, origin))
    return Page(
        title=heading.title or views.title(result),
        about=tuple(f"{sentence(line)}." for line in views.about(result)),
        warning="" if result.sound else f"Not sound: {views.unsound}",
        sections=(*sections, provenance.section(documents)),
        created=origin["created"],
        heading=heading,
    )


def _with_headlines(first: Section, beside: Iterable[Any]) -> Section:
    """Say on the first page what the results beside found, under its large type."""
    said = [
        Prose(line, lead=next(iter(kind_of(other).views.sections)).capitalize())
        for other in beside
        for line in kind_of(other).views.headlines(other)
    ]
    large, *rest = first.blocks
    return replace(first, blocks=(large, *said, *rest))


def chapters(result: Any, *beside: Any) -> list[tuple[str, Callable[[], Section | None]]]:
    """List what makes the chapters of a page, in reading order, by their names.

    Of chapters that several results have, such as maps of their cameras, the first one's stands.
    """
    views = kind_of(result).views
    pairs = [(result, views.sections)]
    pairs += [(other, kind_of(other).views.sections) for other in beside]
    pairs.append((result, views.appendix))
    found: dict[str, Callable[[], Section | None]] = {}
    for of, makers in pairs:
        for name, make in makers.items():
            found.setdefault(name, partial(make, of))
    return list(found.items())


def html(page: Page) -> str:
    """Render a page as one self-contained HTML text, numbered; all text is escaped."""
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
    page = replace(page, sections=numbered(page.sections))
    return environment.get_template("template.html.j2").render(page=page, **own)


def save_report(
    result: Any,
    path: str | Path,
    *,
    title: str = "",
    camera: str = "",
    serial: str = "",
    operator: str = "",
    force: bool = False,
) -> None:
    """Write a result as one self-contained HTML page.

    Parameters
    ----------
    result : Comparison, FamilyComparison or OutlierStudy
        Sections that need a defence (``defend=True``) are left out where it has none.
    path : str or Path
    title : str, optional
        Heads the page; by default what the setup says, or what the kind of result is.
    camera, serial, operator : str, optional
        For the title block: which camera was calibrated, its serial number, and by whom; by
        default what the setup says (``[report]``).
    force : bool, optional
        Replace an existing file.

    Raises
    ------
    OutputError
        Where the file exists (without `force`) or can't be written.
    """
    heading = Heading(title, camera, serial, operator)
    made = html(page_of(result, "bayescal.save_report", heading=heading))
    write_whole(Path(path), made.encode(), force=force)
