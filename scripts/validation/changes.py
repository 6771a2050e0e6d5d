"""How often a camera that changed is called changed, over simulated calibrations; Markdown."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

import bayescal as bc
from bayescal.arrays import Array
from scripts.validation.predictions import KINDS, as_it_was
from scripts.validation.sections import of_each, options_of, publish_as_made

HEADING = "## Changes of a camera that are seen"
# What happened to it: px aside in r, and by which factor its focal lengths grew.
CHANGES = {
    "1 px aside": (1.0, 1.0),
    "0.2 % longer": (0.0, 1.002),
    "1 % longer": (0.0, 1.01),
}


def seen(name: str, seed: int, number: int) -> Array:
    """Which changes are called so at 5 %, ``(n_changes,)``: each by a calibration of its own."""
    kind = KINDS[name]
    streams = np.random.default_rng([seed, number]).spawn(1 + len(CHANGES))
    before = kind.calibrated(streams[0], as_it_was).camera

    def called(rng: np.random.Generator, aside: float, longer: float) -> bool:
        def moved(pixels: Array) -> Array:
            return kind.centre + longer * (pixels - kind.centre) + np.array([aside, 0.0])

        return bc.changed(before, kind.calibrated(rng, moved).camera).changed

    return np.array([called(r, *c) for r, c in zip(streams[1:], CHANGES.values(), strict=True)])


def report(options: argparse.Namespace) -> Iterator[str]:
    """Yield the section's lines."""
    yield from (
        HEADING,
        "",
        f"`./scripts/validate changes --sets {options.sets} --seed {options.seed}`. Calibrations "
        "as of the section on predictions,",
        "one of the camera as it was and one after each change: its image moved aside, its focal "
        "lengths grown.",
        "Per cent of pairs that `bayescal changed` calls changed at 5 %, with standard errors:",
        "",
        f"| model | pairs | {' | '.join(CHANGES)} |",
        f"|---|---|{'---|' * len(CHANGES)}",
    )
    for name in KINDS:
        cases = [(name, options.seed, number) for number in range(options.sets)]
        found = np.array(of_each(seen, cases, options), dtype=float)
        cells = (
            f"{100 * share:.0f} ± {100 * np.sqrt(share * (1 - share) / len(found)):.0f} %"
            for share in found.mean(axis=0)
        )
        yield f"| {name} | {len(found)} | {' | '.join(cells)} |"


def main() -> None:
    """Measure, and print or write."""
    options = options_of("scripts/validate changes", __doc__, HEADING, 100, 2)
    publish_as_made(report(options), HEADING, options.out)


if __name__ == "__main__":
    main()
