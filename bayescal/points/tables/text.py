"""Text that people wrote: read as UTF-8, with complaints that name the line."""

from __future__ import annotations

import codecs

from bayescal.errors import InputError

_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_ZIP = b"PK\x03\x04"
# As much of a faulty text as a message quotes.
_QUOTED = 40


def decode(name: str, raw: bytes) -> str:
    """Decode a file's bytes, with or without a byte-order mark.

    Parameters
    ----------
    name : str
        The file, for messages.

    Raises
    ------
    InputError
        Where they are not UTF-8 text; the message names the line.
    """
    if raw.startswith(_UTF16):
        raise InputError(f"{name}:1: is UTF-16 text; save the file as UTF-8")
    if raw.startswith(_ZIP):
        raise InputError(
            f"{name}: is a zip archive, perhaps a workbook (.xlsx) that was cut off; save it anew"
        )
    if b"\0" in raw:
        line = raw.count(b"\n", 0, raw.index(b"\0")) + 1
        raise InputError(f"{name}:{line}: holds a null byte, so it is not text; give a text file")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(f"{name}:{line}: is not UTF-8 text; save the file as UTF-8") from None


def reason(error: Exception) -> str:
    """Say in a few words why a file could not be read."""
    if isinstance(error, IsADirectoryError):
        return "is a directory"
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror.lower()
    return " ".join(str(error).split())


def quoted(text: str) -> str:
    """Quote a text for a message, no more of it than a line can bear."""
    return repr(text) if len(text) <= _QUOTED else repr(text[:_QUOTED]) + "..."
