"""A progress bar, where somebody sees it."""

from __future__ import annotations

import argparse
import sys
from typing import Any


class Progress:
    """A progress bar on a terminal, once a second has passed."""

    def __init__(
        self,
        options: argparse.Namespace,
        total: int,
        doing: str = "sampling",
        unit: str = "model",
    ) -> None:
        shown = options.progress
        if shown is None:
            shown = sys.stderr.isatty() and not options.quiet
        self._bar: Any = None
        self._doing = doing
        if shown:
            from tqdm import tqdm

            many = total > 10_000
            self._bar = tqdm(
                total=total, unit=unit, unit_scale=many, delay=1, leave=False, file=sys.stderr
            )

    def __call__(self, axis: str, order: int) -> None:
        """Count one model more, now being sampled."""
        self.named(f"{axis}, order {order}")

    def named(self, what: str) -> None:
        """Count one thing more, now being done, by its name."""
        if self._bar is not None:
            self._bar.set_description(f"{self._doing} {what}", refresh=False)
            self._bar.update()

    def more(self, count: int) -> None:
        """Count so many things more."""
        if self._bar is not None:
            self._bar.set_description(self._doing, refresh=False)
            self._bar.update(count)

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
