"""Rows that a caller gives as an array or a data frame, and their answers as the like."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bayescal.errors import InputError


def numbers_of(given: Any, names: tuple[str, ...], what: str) -> Any:
    """Take the named columns of a data frame; anything else as it is."""
    if not hasattr(given, "columns"):
        return given
    missing = [name for name in names if name not in given.columns]
    if missing:
        needed = ", ".join(names)
        raise InputError(f"{what}: the data frame has no column {missing[0]!r}; it needs {needed}")
    return np.asarray(given[list(names)])


def answered(given: Any, found: Any, columns: Callable[[Any], dict[str, Any]]) -> Any:
    """Answer a data frame by one: its rows, and what was found."""
    return given.assign(**columns(found)) if hasattr(given, "columns") else found
