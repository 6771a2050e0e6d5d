"""NumPy archives (.npz), read no further than what they are for: no pickles, no bombs."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Callable

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.tables.text import quoted

LARGEST = 256_000_000  # bytes of all arrays read, unpacked
MOST_MEMBERS = 20_000
_BROKEN = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    ValueError,
    KeyError,
    OSError,
    NotImplementedError,
    RuntimeError,
    struct.error,
)


def is_archive(raw: bytes) -> bool:
    """Whether bytes are a zip archive, which an .npz is."""
    return raw.startswith((b"PK\x03\x04", b"PK\x05\x06"))


def read_arrays(name: str, raw: bytes, wanted: Callable[[str], bool]) -> dict[str, Array]:
    """Read the arrays of numbers in an archive.

    Parameters
    ----------
    name : str
        The file, for messages.
    wanted : callable
        Told the name of an array, says whether it is needed; others are not looked at.

    Raises
    ------
    InputError
        Where the archive is broken or too large, or one that is needed holds no plain numbers.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            members = archive.infolist()
            if len(members) > MOST_MEMBERS:
                raise InputError(f"{name}: holds {len(members)} arrays; {MOST_MEMBERS} are read")
            kept = [m for m in members if wanted(m.filename.removesuffix(".npy"))]
            size = sum(m.file_size for m in kept)
            if size > LARGEST:
                raise InputError(
                    f"{name}: holds {size / 1e6:.4g} MB unpacked, more than the {LARGEST / 1e6:g} "
                    "that are read; give fewer views"
                )
            found = {}
            for member in kept:
                # No more than the stated size is unpacked, whatever the archive holds.
                content = archive.read(member)
                found[member.filename.removesuffix(".npy")] = _array(name, member, content)
            return found
    except _BROKEN as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{name}: is no sound .npz ({_short(error)}); save it again") from None


def _array(name: str, member: zipfile.ZipInfo, content: bytes) -> Array:
    """Read one array, after its shape was found to fit the bytes that are there."""
    where = f"{name}: {quoted(member.filename)}"
    stream = io.BytesIO(content)
    version = np.lib.format.read_magic(stream)
    header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }.get(version)
    if header is None:
        raise InputError(f"{where} is of a version of NumPy's format that is not read")
    shape, _, dtype = header(stream)
    if dtype.hasobject:
        raise InputError(
            f"{where} holds pickled objects, which are never read; save arrays of numbers (where "
            "views differ in their points, one array for each view)"
        )
    if dtype.kind not in "fiub":
        raise InputError(f"{where} holds no numbers; save arrays of numbers")
    count = 1
    for side in shape:
        count *= side
    if count < 0 or count * dtype.itemsize != len(content) - stream.tell():
        raise InputError(f"{where} says shape {shape} and holds other data; save it again")
    stream.seek(0)
    return np.asarray(np.lib.format.read_array(stream, allow_pickle=False), dtype=np.float64)


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:80] or type(error).__name__
