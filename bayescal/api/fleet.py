"""Many cameras, each judged alike."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from bayescal.comparison.settings import Settings
from bayescal.errors import InputError, OutputError
from bayescal.files import check_folder
from bayescal.fleets.closed_forms import ClosedForms
from bayescal.fleets.fleet import Fleet
from bayescal.fleets.journal import Journal, locked
from bayescal.fleets.judging import Camera, judge_fleet
from bayescal.fleets.listed import Listed, listed
from bayescal.fleets.record import Record
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import camera_of
from bayescal.points.setup import Setup
from bayescal.points.views.views import Views

# What judges a camera, and the module of this room that it lives in.
MODULES = {"compare": "axes", "calibrate": "calibrate"}
# What `compare` is asked for beside its settings.
ASKED = ("orders", "axis", "hint")
Read = Callable[[Listed], Correspondences | Views]


def fleet(
    cameras: Mapping[str, Any] | Sequence[str | Path] | str | Path,
    *,
    views: bool = False,
    folder: str | Path | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    seed: int = 0,
    setup: Setup | str | Path | None = None,
    read: Read | None = None,
    progress: Callable[[str], None] | None = None,
    command: str = "bayescal.fleet",
    **options: Any,
) -> Fleet:
    """Judge many cameras on many processes, and say which of them are odd.

    Parameters
    ----------
    cameras : str, Path, sequence of them, or mapping
        Files or patterns such as ``"cameras/*.csv"``, or a manifest (a CSV file with the column
        ``file`` and optionally ``camera`` and ``setup``); or points or views by name.
    views : bool, optional
        Whether they are views of a target, for `calibrate`; else points, for `compare`.
    folder : str or Path, optional
        Keeps what is done, so that the same call again does only what is missing; gets a
        Parquet table, a page and a result document.
    scheduler : str, optional
        Address of a Dask scheduler; by default processes are started on this machine.
    workers : int, optional
        How many; by default one for each core.
    seed : int, optional
        Each camera's own seed follows from it and from its points.
    setup : Setup or str or Path, optional
        What is known of cameras that are read from files and have no setup of their own, and the
        title block of the page.
    read : callable, optional
        Reads a camera's file; by default `load` or `load_views`.
    progress : callable, optional
        Told the name of each camera that is done.
    command : str, optional
        How it was asked for, for the provenance.
    **options
        Of `compare` or `calibrate`: numbers, words and lists of them.

    Returns
    -------
    Fleet

    Raises
    ------
    InputError
        Where there are no cameras or no Dask. What is wrong with one camera stands in its row.
    TypeError
        Where `compare` or `calibrate` has no such option.
    OutputError
        Where the folder can't be written, or holds something else.

    Notes
    -----
    Processes are started as by `multiprocessing`: a script that calls this needs
    ``if __name__ == "__main__":`` around it.
    """
    if workers is not None and (workers < 1 or scheduler is not None):
        raise InputError(
            "workers belong to a scheduler; leave them out"
            if scheduler is not None
            else f"workers must be 1 or more, not {workers}"
        )
    if seed < 0:
        raise InputError(f"seed must not be negative, but is {seed}")
    _check_installed()
    by = "calibrate" if views else "compare"
    _check(_judge_named(by), options)
    given = cameras if isinstance(cameras, Mapping) else _listed(cameras)
    settings = {"judged by": by, "seed": seed, **_plain(options)}
    with contextlib.nullcontext() if folder is None else _prepared(Path(folder)) as place:
        found = judge_fleet(
            _cameras(given, read or _reader(setup, views=views)),
            judge,
            settings,
            Journal(place),
            scheduler=scheduler,
            workers=workers,
            progress=progress or (lambda _: None),
        )
        if setup is not None:
            found = dataclasses.replace(found, heading=camera_of(setup).heading)
        if place is not None:
            from bayescal.report.page.fleet import save_fleet

            save_fleet(found, place, command)
    return found


def judge(data: Correspondences | Views, seed: int, settings: Mapping[str, Any]) -> Record:
    """Judge one camera as `compare` or `calibrate` does, and keep what a fleet needs."""
    options = {name: v for name, v in settings.items() if name not in ("judged by", "seed")}
    if settings["judged by"] == "calibrate":
        from bayescal.api.calibrate import calibrate

        return Record.of_lenses(calibrate(data, seed=seed, **options))
    from bayescal.api.axes import compared

    asked = {name: options.pop(name) for name in ASKED if name in options}
    found = compared(data, Settings(seed=seed, **options), lambda *_: ClosedForms(), **asked)
    return Record.of_orders(found)


def _judge_named(name: str) -> Callable[..., Any]:
    """Find `compare` or `calibrate`."""
    found: Callable[..., Any] = getattr(import_module(f"bayescal.api.{MODULES[name]}"), name)
    return found


def _check_installed() -> None:
    """Refuse to begin what could not be ended.

    Raises
    ------
    InputError
    """
    for module in ("distributed", "pyarrow"):
        try:
            import_module(module)
        except ImportError:
            raise InputError(f"a fleet needs {module}; pip install 'bayescal[fleet]'") from None


def _check(function: Callable[..., Any], options: Mapping[str, Any]) -> None:
    """Refuse options that the function does not have, or that are no plain values.

    Raises
    ------
    TypeError
    """
    known = list(inspect.signature(function).parameters)[1:]
    for name in options:
        if name not in known or name == "progress":
            raise TypeError(f"{function.__name__} has no option {name!r} for a fleet")


def _plain(options: Mapping[str, Any]) -> dict[str, Any]:
    """Bring options to JSON values: lists for any sequence, plain numbers for numpy's."""
    made: dict[str, Any] = json.loads(
        json.dumps(options, default=lambda v: v.tolist() if hasattr(v, "tolist") else list(v))
    )
    return made


def _listed(given: Sequence[str | Path] | str | Path) -> dict[str, Listed]:
    files = [given] if isinstance(given, str | Path) else given
    return {camera.name: camera for camera in listed(files)}


def _reader(setup: Setup | str | Path | None, *, views: bool) -> Read:
    """Read files of cameras; a manifest's own setup goes before the one for all."""
    if views:
        from bayescal.points.views.reader import load_views

        return lambda camera: load_views(camera.file, setup=camera.setup or setup)
    from bayescal.points.reader import load

    return lambda camera: load(camera.file, camera.setup or setup)


def _cameras(given: Mapping[str, Any], read: Read) -> Iterable[Camera]:
    """Read cameras one by one as they are needed."""
    for name, source in given.items():
        if not isinstance(source, Listed):
            yield Camera(str(name), getattr(source, "source", ""), source)
            continue
        try:
            yield Camera(name, source.file, read(source))
        except InputError as error:
            yield Camera(name, source.file, None, str(error))


@contextlib.contextmanager
def _prepared(folder: Path) -> Iterator[Path]:
    """Make the folder, or take an earlier one up again; leave none where no camera was begun."""
    from bayescal.report.page.fleet import FOLDER

    if not (folder.is_dir() and not any(folder.iterdir())):
        check_folder(folder, FOLDER, force=True)
    marker, new = folder / FOLDER.marker, not folder.exists()
    try:
        folder.mkdir(exist_ok=True)
        marker.touch()
    except OSError as error:
        raise OutputError(f"{folder}: {(error.strerror or str(error)).lower()}") from None
    with locked(marker):
        try:
            yield folder
        except InputError:
            if not marker.stat().st_size:
                marker.unlink()
                if new:
                    folder.rmdir()
            raise
