"""Sections of docs/validation.md that a script measures: their options, and where they go."""

from __future__ import annotations

import argparse
import hashlib
import pickle
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from bayescal.files import write_whole
from bayescal.fleets.cluster import Task, connected, spread


def options_of(
    program: str, description: str | None, heading: str, sets: int, least: int
) -> argparse.Namespace:
    """Read how many data sets to make, with which seed, and where the section goes.

    Parameters
    ----------
    program : str
    description : str or None
    heading : str
        Of the section.
    sets, least : int
        Data sets of each kind by default, and at least.
    """
    parser = argparse.ArgumentParser(prog=program, description=description)
    parser.add_argument(
        "--sets", type=int, default=sets, help=f"data sets of each kind ({sets}; from {least})"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the random numbers (0)")
    parser.add_argument(
        "--workers", type=int, default=1, help="processes, which change no result (1)"
    )
    parser.add_argument(
        "--keep", metavar="FOLDER", help="keep what comes of each data set, and go on from there"
    )
    parser.add_argument(
        "--out", metavar="FILE.md", help=f"put the section {heading!r} into this file (printed)"
    )
    options = parser.parse_args()
    if options.sets < least or options.seed < 0 or options.workers < 1:
        parser.error(f"--sets must be at least {least}, --seed not negative, --workers positive")
    return options


def of_each(
    function: Callable[..., Any], cases: Sequence[tuple[Any, ...]], options: argparse.Namespace
) -> list[Any]:
    """Call a function on each case, on processes as a fleet's cameras are judged.

    Parameters
    ----------
    function : callable
        What comes of a case depends on its arguments alone, its seed among them.
    cases : sequence of tuple
        Arguments.
    options : argparse.Namespace
        With ``workers``, processes (with one, the cases are done here), and ``keep``, a folder
        from which is read what an earlier run made of a case; the code must be the same.

    Returns
    -------
    list
        In the order of the cases.
    """
    if options.keep:
        # Named here: to other processes a script's function comes without its file.
        name = f"{Path(function.__code__.co_filename).stem}.{function.__name__}"
        function = partial(_kept, function, Path(options.keep) / name)
    if options.workers == 1:
        with threadpool_limits(1):
            return [function(*case) for case in cases]
    tasks = [Task(str(number), case) for number, case in enumerate(cases)]
    with connected(None, options.workers) as client:
        found = {task.key: outcome for task, outcome in spread(client, function, tasks)}
    for outcome in found.values():
        if isinstance(outcome, BaseException):
            raise outcome
    return [found[task.key] for task in tasks]


def _kept(function: Callable[..., Any], name: Path, *case: Any) -> Any:
    place = Path(f"{name}.{hashlib.sha256(repr(case).encode()).hexdigest()[:16]}")
    if place.exists():
        return pickle.loads(place.read_bytes())
    found = function(*case)
    place.parent.mkdir(parents=True, exist_ok=True)
    write_whole(place, pickle.dumps(found))
    return found


def publish(section: str, heading: str, out: str | None) -> None:
    """Print a section, or put it into a Markdown file in place of the one there."""
    if out is None:
        sys.stdout.write(section)
        return
    place = Path(out)
    text = place.read_text(encoding="utf-8") if place.exists() else ""
    write_whole(place, with_section(text, section, heading).encode(), force=True)


def publish_as_made(lines: Iterable[str], heading: str, out: str | None) -> None:
    """Print the lines of a section while they are measured; then put it into a file, if any."""
    made = []
    for line in lines:
        print(line, flush=True)
        made.append(line)
    if out is not None:
        publish("\n".join(made) + "\n", heading, out)


def with_section(text: str, section: str, heading: str) -> str:
    """Replace the section of a Markdown text, or add it at the end."""
    pattern = re.compile(rf"^{re.escape(heading)}$.*?(?=^## |\Z)", re.MULTILINE | re.DOTALL)
    if pattern.search(text):
        return pattern.sub(lambda _: section + "\n", text).rstrip("\n") + "\n"
    return f"{text.rstrip()}\n\n{section}".lstrip("\n")
