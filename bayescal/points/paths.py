"""Files that names and patterns of names mean."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.tables.text import reason


def named_paths(given: Iterable[str | Path], what: str, example: str) -> list[Path]:
    """Files that names and patterns of names mean, each once, patterns in order of name.

    Parameters
    ----------
    what : str
        What they are, in the plural, for messages.
    example : str
        Of a pattern, for messages.

    Raises
    ------
    InputError
        Where one means none.
    """
    found: dict[Path, None] = {}
    for one in given:
        path = Path(one)
        try:
            inside = Path(path.anchor).glob(str(path.relative_to(path.anchor)))
            files = [path] if path.is_file() else sorted(p for p in inside if p.is_file())
        except (OSError, ValueError, NotImplementedError) as error:
            raise InputError(f"{one}: {reason(error)}; name {what}") from None
        if not files:
            where = ": is a folder; name its files" if path.is_dir() else ": there is no such file"
            raise InputError(f"{one}{where}, such as {example!r}")
        found.update(dict.fromkeys(files))
    if not found:
        raise InputError(f"there are no {what}; name them, such as {example!r}")
    return list(found)


def short_names(paths: Iterable[Path]) -> list[str]:
    """Names of files, or with their folders where those alone do not tell them apart."""
    given = list(paths)
    names = [path.name for path in given]
    return names if len(set(names)) == len(names) else [str(path) for path in given]
