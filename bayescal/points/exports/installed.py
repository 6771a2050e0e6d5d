"""Readers of other libraries, where somebody has installed them."""

from __future__ import annotations

import io
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from bayescal.errors import InputError
from bayescal.points.tables.content import Content


def read_frame(
    content: Content, kind: str, needs: tuple[str, ...], reader: str, stream: io.BytesIO
) -> Any:
    """Read a data frame with pandas.

    Parameters
    ----------
    kind : str
        What the file is, for messages.
    needs : tuple of str
        Packages that have to be installed.
    reader : str
        The function of pandas.
    stream : io.BytesIO
        What it reads.

    Raises
    ------
    InputError
        Where a package is missing, or the file is damaged.
    """
    missing = [name for name in needs if find_spec(name) is None]
    if missing:
        raise InputError(
            f"{content.name}: is an {kind}, read with {' and '.join(needs)}: install "
            f"{' '.join(missing)}, or save it as CSV"
        )
    try:
        return getattr(import_module("pandas"), reader)(stream)
    except Exception as error:  # whatever a damaged file makes the library raise
        reason = " ".join(str(error).split()).partition(". ")[0].rstrip(".")
        raise InputError(f"{content.name}: is a damaged {kind}: {reason}; save it anew") from None
