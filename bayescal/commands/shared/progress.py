"""How far a command is: a line on a terminal that moves from the first half second."""

from __future__ import annotations

import sys
import threading
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import argparse

DELAY = 0.5  # seconds before anything is shown: what is quick shows nothing
# Models that a step of none takes as long as: a defence, a family, a look at other models.
HEAVY = 10


class Progress:
    """A line with time taken and time left, on a terminal, once half a second has passed.

    Parameters
    ----------
    options : argparse.Namespace
        Says by ``progress`` and ``quiet`` whether there is one.
    total : int
        How many things there are to do.
    doing : str
        What is done with them.
    heavy : int
        How many steps there are beside, each as long as many things.
    """

    def __init__(
        self, options: argparse.Namespace, total: int, doing: str = "sampling", heavy: int = 0
    ) -> None:
        shown = options.progress
        if shown is None:
            shown = sys.stderr.isatty() and not options.quiet
        self._doing, self._total, self._shown = doing, total + HEAVY * heavy, bool(shown)
        self._running = 0  # weight of what is being done now
        self._done, self._begun = 0, time.perf_counter()
        self._task: Any = None

    def __call__(self, what: str, order: int) -> None:
        """Begin an order of an axis, or with order 0 what is no order."""
        if order:
            self.named(f"{what}, order {order}")
        else:
            self._begin(what, HEAVY)

    def named(self, what: str) -> None:
        """Begin one thing more, by its name."""
        self._begin(f"{self._doing} {what}", 1)

    def _begin(self, words: str, weight: int) -> None:
        """Count what was being done until now, and say what is done from now on."""
        self._move(self._running, words)
        self._running = weight

    def more(self, count: int) -> None:
        """Count so many small things more, and say how many a second there are."""
        self._done += count
        rate = self._done / max(time.perf_counter() - self._begun, 1e-9)
        self._move(count, f"{self._doing} {rate:,.0f} a second")

    def _move(self, count: int, words: str) -> None:
        if self._task is not None:
            at = {"at": time.perf_counter() - self._begun} if count else {}
            _LINES.display.update(self._task, advance=count, description=words, **at)

    def __enter__(self) -> Progress:
        if self._shown:
            self._task = _LINES.add(self._doing, self._total)
        return self

    def __exit__(self, *_: object) -> None:
        if self._task is not None:
            _LINES.remove(self._task)
            self._task = None


class _Lines:
    """The lines of all that is being done, which share the terminal."""

    def __init__(self) -> None:
        self.display: Any = None
        self._lock = threading.Lock()
        self._count = 0

    def add(self, words: str, total: int) -> Any:
        """Add a line; the first makes all appear after a while."""
        with self._lock:
            if self.display is None:
                self.display = _display()
                timer = threading.Timer(DELAY, self._start)
                timer.daemon = True
                timer.start()
            self._count += 1
            return self.display.add_task(words, total=total, at=0.0)

    def _start(self) -> None:
        with self._lock:
            if self.display is not None:
                self.display.start()

    def remove(self, task: Any) -> None:
        """Remove a line; with the last the terminal is as it was."""
        with self._lock:
            self.display.remove_task(task)
            self._count -= 1
            if self._count == 0:
                self.display.stop()
                self.display = None


_LINES = _Lines()


def time_left(done: float, total: float, at: float, now: float) -> str:
    """Say how long what is left takes at the pace until now, h:mm:ss; unknown before a first step.

    Parameters
    ----------
    done, total : float
        Steps.
    at, now : float
        Seconds that had been taken when the last of them was done, and now.
    """
    if not done:
        return "-:--:--"
    left = round(max(at * total / done - max(now, at), 0.0))
    return f"{left // 3600}:{left // 60 % 60:02}:{left % 60:02}"


def _display() -> Any:
    """Lines that are redrawn four times a second by a thread of their own, and leave nothing."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        SpinnerColumn,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
    )

    class Left(ProgressColumn):
        """Time left as the steps done until now tell: from the first of them on."""

        def render(self, task: Any) -> Any:
            return time_left(task.completed, task.total, task.fields["at"], task.elapsed or 0.0)

    return Progress(
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=24),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        Left(),
        console=Console(file=sys.stderr, force_terminal=True),
        transient=True,
        refresh_per_second=4,
        redirect_stdout=False,
        redirect_stderr=False,
    )
