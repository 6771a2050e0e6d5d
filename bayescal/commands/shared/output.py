"""Output that commands share: tables, the result document, a run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.commands.shared.option import option
from bayescal.commands.shared.streams import say
from bayescal.errors import InputError

if TYPE_CHECKING:
    from bayescal.files import FolderKind
    from bayescal.report.run.kind import Kind

DONE, BAD_INPUT, NOT_SOUND = 0, 2, 3


RUN_HELP = "write a run: result.json, draws (NetCDF), corner plots"


def add_output(
    parser: argparse.ArgumentParser,
    folder_help: str | None = RUN_HELP,
    *,
    progress: bool = True,
) -> None:
    """Add where results go (no folder without its help), and whether progress is shown."""
    output = parser.add_argument_group("output")
    option(output, "--json FILE|-", "write the result document; - prints it instead of tables")
    if folder_help is not None:
        option(output, "--out DIR", folder_help)
    option(output, "--force", "replace existing output")
    option(output, "--quiet", "print no tables")
    if progress:
        add_progress(output)


def add_manner(output: argparse._ArgumentGroup, quiet: str) -> None:
    """Add whether files are replaced, what is left unsaid, and whether progress is shown."""
    option(output, "--force", "replace existing output")
    option(output, "--quiet", quiet)
    add_progress(output)


def add_progress(group: argparse._ArgumentGroup) -> None:
    """Add whether progress is shown."""
    option(
        group,
        "--progress",
        "progress bar (on a terminal, after half a second)",
        action=argparse.BooleanOptionalAction,
    )


def check_file(options: argparse.Namespace, path: Path) -> None:
    """Refuse, before any work is done, a file that can't be written, or that is read.

    Raises
    ------
    OutputError
        Where it can't be written.
    InputError
        Where the command reads it, or it is part of the run that is read: even --force
        must not cost anybody their data.
    """
    from bayescal.files import check_free

    if str(path) == "-":
        raise InputError("-: this can't be written to standard output; name a file")
    check_free(path, force=options.force)
    place = path.resolve()
    for name in ("points", "setup", "like", "world", "pixels", "views"):
        given = getattr(options, name, None)
        if given in (None, "", "-"):
            continue
        read = Path(given).resolve()
        if place == read or (path.exists() and read in place.parents and _of_run(place, read)):
            raise InputError(f"{path}: would replace what is read; choose another name")


def _of_run(place: Path, folder: Path) -> bool:
    """Whether a path within a folder belongs to a run there."""
    from fnmatch import fnmatch

    from bayescal.report.run.folder import RUN

    name = place.relative_to(folder).parts[0]
    return any(fnmatch(name, pattern) for pattern in (RUN.marker, *RUN.contents))


def check_output(options: argparse.Namespace, folder: FolderKind | None = None) -> None:
    """Refuse output that can't be written before anything is computed.

    Parameters
    ----------
    folder : FolderKind, optional
        What --out is; a run by default.
    """
    document = None if options.json in (None, "-") else Path(options.json)
    if document is not None:
        check_file(options, document)
    if options.out is None:
        return
    from bayescal.files import check_folder
    from bayescal.report.run.folder import RUN

    kind = folder or RUN
    if options.out == "-":
        raise InputError(f"-: a {kind.name} is a folder; name one (--json - prints the numbers)")
    place = Path(options.out)
    if document is not None and place.absolute() in (
        document.absolute(),
        *document.absolute().parents,
    ):
        raise InputError(
            f"{options.json}: lies in --out, which holds the document anyway; drop --json"
        )
    check_folder(place, kind, force=options.force)


def publish(
    options: argparse.Namespace,
    result: Any,
    *,
    full: bool = False,
    kind: Kind[Any] | None = None,
) -> None:
    """Write and print whatever was asked for of a result.

    Parameters
    ----------
    full : bool, optional
        Print everything there is to say.
    kind : Kind, optional
        Of the result, where it is none that runs hold.
    """
    prints = not options.quiet and options.json != "-"
    if not prints and options.json is None and options.out is None:
        return
    from bayescal.report.runs import kind_of

    kind = kind or kind_of(result)
    if options.json is not None or options.out is not None:
        made = kind.text(result, options.command_line)
        if options.out is not None:
            kind.write(Path(options.out), result, made, force=options.force)
        if options.json == "-":
            sys.stdout.write(made)
        elif options.json is not None:
            from bayescal.files import write_whole

            write_whole(Path(options.json), made.encode(), force=options.force)
    if prints:
        from bayescal.report.terminal import printed

        sys.stdout.write(printed(kind.view(result, full=full)))


def deliver(options: argparse.Namespace, result: Any, *, full: bool = False) -> int:
    """Publish a result that may be unsound; give the exit code."""
    publish(options, result, full=full)
    return code_of(sound=result.sound)


def code_of(*, sound: bool) -> int:
    """Give the exit code of a result, and say why where it is not 0."""
    if sound:
        return DONE
    say(
        "some draws did not converge or disagree with the closed form, or an evidence should not "
        "be trusted (exit code 3)"
    )
    return NOT_SOUND
