"""Every camera of a fleet judged once, on many processes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any, TypeAlias

from bayescal.errors import InputError
from bayescal.fleets.cluster import Task, connected, spread
from bayescal.fleets.fleet import Fleet
from bayescal.fleets.journal import Journal
from bayescal.fleets.record import Member, Record
from bayescal.points.correspondences import Correspondences
from bayescal.points.views.views import Views
from bayescal.version import __version__

Progress: TypeAlias = Callable[[str], None]
Judge: TypeAlias = Callable[[Correspondences | Views, int, Mapping[str, Any]], Record]


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera of a fleet: its points or views, or why they can't be read."""

    name: str
    file: str
    data: Correspondences | Views | None
    error: str = ""


def judge_fleet(
    cameras: Iterable[Camera],
    judge: Judge,
    settings: Mapping[str, Any],
    journal: Journal,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress = lambda _: None,
) -> Fleet:
    """Judge every camera that the journal does not hold, on many processes.

    What comes of a camera depends on its points, the settings and the seed alone, not on the
    other cameras, nor on how many processes there are.

    Parameters
    ----------
    cameras : iterable of Camera
        Read as they are needed.
    judge : callable
        Given data, seed and settings on a worker; a failure it raises is that of one camera.
    settings : mapping
        JSON values, with a ``"seed"``; part of a camera's key in the journal.
    progress : callable, optional
        Told the name of each camera that is done.

    Raises
    ------
    InputError
        Where there is no cluster.
    """
    members: dict[str, Member] = {}
    going: dict[str, list[Camera]] = {}
    taken, earlier = 0, frozenset(journal)

    def missing() -> Iterator[Task]:
        nonlocal taken
        for camera in cameras:
            members[camera.name] = Member(camera.name, camera.file, None, camera.error)
            digest = "" if camera.data is None else digest_of(camera.data)
            key = _digest(digest, settings)
            if camera.data is None or key in journal:
                taken += key in earlier
                _settle(members, camera, journal.get(key))
                progress(camera.name)
                continue
            going.setdefault(key, []).append(camera)
            if len(going[key]) == 1:  # cameras of the same points are judged once
                yield Task(key, (judge, camera.data, seed_of(digest, settings), dict(settings)))

    waiting = missing()
    first = next(waiting, None)
    if first is not None:  # without any, no process is started
        with connected(scheduler, workers) as client:
            for task, outcome in spread(client, _judged, chain([first], waiting)):
                if isinstance(outcome, Record):
                    journal.add(task.key, outcome)
                for camera in going.pop(task.key):
                    _settle(members, camera, outcome)
                    progress(camera.name)
    found = tuple(members.values())
    return Fleet(found, dict(settings), taken=taken)


def digest_of(data: Correspondences | Views) -> str:
    """Hash what a judgement depends on: numbers, groups, the camera; not names of files."""
    arrays: list[Any] = [data.world, data.pixels]
    words: list[Any]
    if isinstance(data, Correspondences):
        arrays += [data.sigma[name] for name in sorted(data.sigma)]
        words = [sorted(data.sigma), data.groups, data.setup]
    else:
        arrays += [data.view, *([] if data.sigma is None else [data.sigma])]
        words = [data.width, data.height, data.relative_sigma]
    found = hashlib.sha256(repr(words).encode())
    for array in arrays:
        found.update(array.tobytes())
    return found.hexdigest()


def seed_of(digest: str, settings: Mapping[str, Any]) -> int:
    """Seed of a camera's random numbers: its own, whatever its place in the fleet."""
    return int(_digest(digest, {"seed": settings["seed"]})[:8], 16)


def _digest(digest: str, settings: Mapping[str, Any]) -> str:
    text = json.dumps([__version__, digest, settings], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _judged(
    judge: Judge, data: Correspondences | Views, seed: int, settings: Mapping[str, Any]
) -> Record | str:
    """Judge one camera on a worker; say why where it can't be, whatever the reason."""
    try:
        return judge(data, seed, settings)
    except InputError as error:
        return str(error)
    except Exception as error:
        return f"{data.source}: failed: {type(error).__name__}: {' '.join(str(error).split())}"


def _settle(members: dict[str, Member], camera: Camera, outcome: Any) -> None:
    """Note what became of a camera: its record, or why there is none."""
    record = outcome if isinstance(outcome, Record) else None
    error = "" if record is not None else camera.error or _why(camera, outcome)
    members[camera.name] = Member(camera.name, camera.file, record, error)


def _why(camera: Camera, outcome: Any) -> str:
    if isinstance(outcome, str):
        return outcome
    if type(outcome).__name__ == "KilledWorker":
        return f"{camera.file}: every process that judged it ended (out of memory?); judge it alone"
    return f"{camera.file}: failed: {type(outcome).__name__}: {' '.join(str(outcome).split())}"
