"""A fleet of cameras as a folder: a page, a table in Parquet and a document."""

from __future__ import annotations

from pathlib import Path

from bayescal.files import FolderKind, write_whole
from bayescal.fleets.fleet import Fleet
from bayescal.fleets.journal import NAME
from bayescal.fleets.table import parquet_bytes
from bayescal.report.blocks import Block, Section
from bayescal.report.document.fleet import fleet_document
from bayescal.report.document.shared import dumps
from bayescal.report.figures.fleet import draw_spread, spread_text
from bayescal.report.page.page import Page, html
from bayescal.report.page.pictures import pictured
from bayescal.report.views import fleet as views
from bayescal.report.views import provenance
from bayescal.rounding import counted

TABLE, PAGE, DOCUMENT = "cameras.parquet", "index.html", "fleet.json"
FOLDER = FolderKind("fleet", NAME, (TABLE, PAGE, DOCUMENT, ".bayescal-*"))


def save_fleet(fleet: Fleet, folder: Path, command: str) -> None:
    """Write table, page and document of a fleet into its folder, in place of earlier ones.

    Raises
    ------
    OutputError
        Where they can't be written.
    """
    document = fleet_document(fleet, command)
    told = {"bayescal.settings": fleet.settings, "bayescal.common": fleet.common}
    made = {
        TABLE: parquet_bytes(fleet.columns, told),
        DOCUMENT: dumps(document).encode(),
        PAGE: html(fleet_page(fleet, document)).encode(),
    }
    for name, raw in made.items():
        write_whole(folder / name, raw, force=True)


def fleet_page(fleet: Fleet, document: dict[str, object]) -> Page:
    """Collect everything that the page shows."""
    first, *rest = views.sections(fleet)
    spread = (_spread(fleet),) if fleet.spreads else ()
    origin = document["provenance"]
    assert isinstance(origin, dict)
    wrong = len(fleet.failed) + len(fleet.unsound)
    return Page(
        title=fleet.heading.title or "A fleet of cameras",
        about=tuple(f"{line}." for line in views.about(fleet)),
        warning=f"{counted(wrong, 'camera')} not judged, or not soundly." if wrong else "",
        sections=(first, *spread, *rest, provenance.section({"fleet": document})),
        created=origin["created"],
        heading=fleet.heading,
    )


def _spread(fleet: Fleet) -> Section:
    blocks: list[Block] = [views.spread(fleet)]
    if any(s.scale is not None for s in fleet.spreads):
        caption = (
            "Every camera's distance from the fleet's median; beyond the dashed lines it is odd. "
            "Cameras further away stand at the edge."
        )
        blocks.insert(0, pictured("figure-spread", draw_spread(fleet), spread_text(fleet), caption))
    lead = "How much do the cameras differ, and which stand apart?"
    return Section("spread-of-fleet", "The fleet's spread", lead, tuple(blocks))
