"""Predictions as a table."""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.points.tables.partial import PartialTable
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.columns import remarks
from bayescal.prediction.predict import Prediction
from bayescal.report.blocks import Blocks, Listing, Tabled
from bayescal.report.table import Cell, answers_table
from bayescal.rounding import counted, rounded, significant

SHOWN = 30  # rows on a terminal


def prediction_view(camera: CalibratedCamera, table: PartialTable, found: Prediction) -> Blocks:
    """Show predictions and what they rest on."""
    percent = f"{100 * found.probability:g}%"
    forms = ("{} [px]", "sd {}", "new sd {}", f"{{}}, {percent}")
    heads = ["point", *(form.format(axis) for form in forms for axis in "rc"), ""]

    def cells(i: int) -> list[Cell] | None:
        if not found.seen[i]:
            return None
        mean, sd, new = found.mean[i], found.sd[i], found.new_sd[i]
        ends = zip(found.lower[i], found.upper[i], new, strict=True)
        return [
            *(Cell(rounded(m, s)) for m, s in zip(mean, sd, strict=True)),
            *(Cell(significant(s)) for s in (*sd, *new)),
            *(Cell(f"{rounded(a, s)}..{rounded(b, s)}") for a, b, s in ends),
        ]

    notes = [_short(text) for text in remarks(found)[:SHOWN]]
    shown = answers_table(heads, names_of(table), cells, notes, spare=heads[-3:-1])
    return (
        Listing((f"{counted(len(found), 'point')}, {models_words(camera)}",), "about"),
        Tabled("predictions", "Predictions.", shown, tuple(_lines(camera, found))),
    )


def _short(remark: str) -> str:
    return "not seen" if remark.startswith("behind") else remark.replace(" the image", "")


def names_of(table: PartialTable) -> list[tuple[Cell]]:
    """Name the rows that are shown."""
    return [(Cell(clipped(label)),) for label in table.labels[:SHOWN]]


def clipped(label: str, most: int = 14) -> str:
    """Shorten a label that would take a table's width."""
    return label if len(label) <= most else label[: most - 1] + "…"


def models_words(camera: CalibratedCamera) -> str:
    """Which models the answers come from."""
    members, weights = camera.used
    if len(members) > 1:
        shown = [f"{m.name} {100 * w:.0f}%" for m, w in zip(members, weights, strict=True)]
        more = f"; and {len(shown) - 4} more" if len(shown) > 4 else ""
        return (
            f"averaged over {len(members)} plausible models, which have "
            f"{100 * camera.covered:.0f}% of the probability: {'; '.join(shown[:4])}{more}"
        )
    rest = len(camera.members) - 1
    others = f" ({counted(rest, 'other model')} can't be excluded: --average)" if rest else ""
    return f"by {members[0].name}{others}"


def _lines(camera: CalibratedCamera, found: Prediction) -> list[str]:
    shown = min(len(found), SHOWN)
    lines = []
    if shown < len(found):
        lines.append(f"And {counted(len(found) - shown, 'more point')} (--out FILE has all)")
    lines.append(
        f"sd: of the mapping ({found.method}); new sd: of a new measurement, with its noise; "
        f"central {100 * found.probability:g}% interval of a new measurement."
    )
    seen = found.seen
    if len(camera.used[0]) > 1 and seen.any():
        worst = significant(float(found.between[seen].max()))
        lines.append(f"Between the models: an sd of at most {worst} px, part of sd.")
    flags = (
        (~seen, "behind the camera, or beyond the lens's reach"),
        (found.outside, "outside the image"),
        (found.extrapolated, "beyond where points were calibrated with (extrapolated)"),
    )
    lines += [f"{counted(int(f.sum()), 'point')} {what}." for f, what in flags if f.any()]
    if len(found) and not (seen & ~found.outside).any():
        lines.append("No point appears in the image: are they of another camera?")
    return [*lines, *found.notes]


def bad_rows(problems: Sequence[str], most: int = 20) -> list[str]:
    """Complaints about rows, and how many more there are."""
    more = len(problems) - most
    return [*problems[:most], *([f"and {counted(more, 'more bad row')}"] if more > 0 else [])]
