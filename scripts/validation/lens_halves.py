"""Whether two halves of a real set of views give one calibration; prints a section of Markdown.

Sets that are large enough, which are not kept here:

opencv8-0.cameramodel    186 views, 6016 by 4016 px, Apache-2.0; github.com/dkogan/mrcal,
                         doc/data/figueroa-overpass-looking-S/
wide_angle_charuco.npz   101 views, 3088 by 2064 px, MIT; github.com/Robertleoj/camcal,
                         data/test_datasets/
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import bayescal as bc
from bayescal.arrays import Array
from bayescal.rounding import significant
from scripts.validation.sections import of_each, publish

HEADING = "## Lens models over many views: halves of real sets"
SIMPLE = ("fisheye 1", "opencv8")


def main() -> None:
    """Calibrate both halves with each lens, and compare."""
    parser = argparse.ArgumentParser(
        prog="scripts/validate lens-halves",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", metavar="FILE", help="views, as calibrate reads them")
    parser.add_argument(
        "--lenses",
        nargs="+",
        metavar="LENS",
        default=list(SIMPLE),
        help=f"compared beside what is recommended ({', '.join(SIMPLE)})",
    )
    parser.add_argument(
        "--among",
        nargs="+",
        metavar="LENS",
        help="what is recommended is one of these (by default, of those that calibrate finds)",
    )
    parser.add_argument("--workers", type=int, default=1, help="processes (1)")
    parser.add_argument("--keep", metavar="FOLDER", help="keep what comes of each set")
    parser.add_argument("--out", metavar="FILE.md", help="put the section into this file")
    options = parser.parse_args()
    publish("\n".join(report(options)) + "\n", HEADING, options.out)


def report(options: argparse.Namespace) -> Iterator[str]:
    """Yield the section's lines."""
    yield from (
        HEADING,
        "",
        "`scripts/validate lens-halves FILE...`, whose help says where to get the files. Every "
        "second view is calibrated apart from the",
        "others, and the two are compared as `bayescal changed` does, the turn that poses absorb "
        "taken out. Shift: difference of the two",
        "where both have points, root mean square and largest; sd: of that difference as the two "
        "state it, root mean square; p: probability",
        "of so large a difference by chance.",
        "",
        "| views | lens | shift, px | largest | sd, px | p |",
        "|" + "---|" * 6,
    )
    wanted = (options.among, *([lens] for lens in options.lenses))
    cases = [(file, lenses) for file in options.files for lenses in wanted]
    for (file, _), cells in zip(cases, of_each(compared, cases, options), strict=True):
        yield f"| {Path(file).stem} | " + " | ".join(cells) + " |"


def compared(file: str, lenses: list[str] | None) -> list[str]:
    """Calibrate every second view and the others; the cells of a line."""
    views = bc.load_views(file)
    halves = [views.select(range(first, len(views), 2)) for first in (0, 1)]
    found = [bc.calibrate(half, lenses=lenses) for half in halves]
    change = bc.changed(*map(bc.camera, found))
    inside = change.places.inside
    shift, sd = rms(change.size[inside]), rms(np.sqrt(2) * change.sd[inside])
    name = ", ".join(dict.fromkeys(f.best.name for f in found))
    if lenses is None or len(lenses) > 1:
        name = f"recommended: {name}"
    p = "< 0.0001" if change.p_value < 1e-4 else f"{change.p_value:.2g}"
    largest = significant(float(change.size[inside].max()))
    return [name, significant(shift), largest, significant(sd), p]


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


if __name__ == "__main__":
    main()
