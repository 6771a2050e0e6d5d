"""Where in the image a calibration can be believed, in numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import BoolArray
from bayescal.prediction.maps import NAMES, ImageMaps, image_maps
from bayescal.prediction.sights import Sights
from bayescal.report.blocks import Blocks, Figure, Listing, Section, Tabled
from bayescal.report.table import Cell, Column, Table, answers_table
from bayescal.report.views.prediction import models_words
from bayescal.rounding import counted, significant

Result = TypeVar("Result")
MOST = 3  # other models, in sentences and columns
SD_CAPTION = (
    "Standard deviation of the mapping and of a new measurement over the image; hatched: beyond "
    "the calibration points, or without an inverse."
)
PLACES_CAPTION = "Over the image, px; r and c as recorded."
DIFFERENCE_CAPTION = (
    "How far the other plausible models predict the points elsewhere that the chosen one sees."
)


def map_view(camera: CalibratedCamera, maps: ImageMaps) -> Blocks:
    """Show deviations at named places, and what other models would move."""
    return (Listing((f"the image {models_words(camera)}",), "about"), *map_blocks(maps))


def map_blocks(maps: ImageMaps) -> Blocks:
    """Show the table and its sentences."""
    return (Tabled("map-places", PLACES_CAPTION, places_table(maps), tuple(_lines(maps))),)


def map_section(result: Result, camera_of: Callable[[Result], CalibratedCamera]) -> Section | None:
    """Make the chapter of a page, with figures; None of a result that holds no camera."""
    try:
        maps = image_maps(camera_of(result))
    except InputError:
        return None
    drawn = [Figure("sd-map", maps, SD_CAPTION)]
    if maps.differences:
        drawn.append(Figure("difference-map", maps, DIFFERENCE_CAPTION))
    lead = "How sure the calibrated mapping is, and what another plausible model would move."
    return Section("maps", "Over the image", lead, (*drawn, *map_blocks(maps)))


def places_table(maps: ImageMaps) -> Table:
    """Make a row for each named place."""
    at = maps.named
    assert at is not None, "of the whole image"
    others = at.differences[:MOST]
    heads = ["place", "r", "c", "sd", "new sd", *["averaged sd"] * bool(others)]
    heads += [f"to {d.other}" for d in others]

    def cells(i: int) -> list[Cell] | None:
        if not at.places.found[i]:
            return None
        spreads = [at.epistemic[i], at.predictive[i], *[at.averaged[i]] * bool(others)]
        return [*(Cell(significant(float(v))) for v in spreads), *(Cell(d.told(i)) for d in others)]

    return answers_table(
        (*heads, Column("", title="remark")),
        places_cells(at.places),
        cells,
        remarks(at.places, at.places.found, "no inverse"),
        spare=heads[:5:-1],
    )


def places_cells(places: Sights) -> list[tuple[Cell, ...]]:
    """Name the named places, and where they are."""
    named = zip(NAMES, places.pixels, strict=True)
    return [(Cell(name), Cell(f"{r:.4g}"), Cell(f"{c:.4g}")) for name, (r, c) in named]


def remarks(places: Sights, known: BoolArray, unknown: str) -> list[str]:
    """Say of each place why nothing is `known` there, or that it is extrapolated."""
    pairs = zip(known, places.inside, strict=True)
    return ["extrapolated" * (not inside) if ok else unknown for ok, inside in pairs]


def _lines(maps: ImageMaps) -> list[str]:
    lines = [
        f"sd: of the mapping by {maps.chosen}, px, root mean square of r and c; new sd: of a new "
        "measurement, px."
    ]
    inside = maps.epistemic[maps.places.inside & np.isfinite(maps.epistemic)]
    if inside.size:
        ends = " to ".join(significant(float(v)) for v in (inside.min(), inside.max()))
        share = 100 * float(maps.places.inside.mean())
        lines.append(
            f"Among the calibration points ({share:.0f}% of the image) sd is {ends} px; elsewhere "
            "the model is extrapolated."
        )
    at = maps.named
    assert at is not None, "of the whole image"
    if any(d.bound(i) for d in at.differences[:MOST] for i in range(len(NAMES))):
        lines.append("<: a difference below its own deviation; it is at most so large (95%).")
    lines += maps.sentences[:MOST]
    more = len(maps.differences) - MOST
    return [*lines, f"And {counted(more, 'more plausible model')}."] if more > 0 else lines
