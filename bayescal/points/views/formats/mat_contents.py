"""Arrays of numbers in a MATLAB file, from elements that are walked one by one.

scipy's reader unpacks whatever a file says, and a broken file can end the process in it. This
walks the elements (MathWorks, "MAT-File Format", level 5), unpacks no more than a stated size, and
takes the variables that are arrays of numbers and exactly as large as they say.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError

LARGEST = 256_000_000  # bytes of all variables, unpacked
HEADER = 128
MATRIX, COMPRESSED = 14, 15
NUMERIC = range(6, 16)  # classes: double, single, and integers of all widths
# Types of stored values: signed and unsigned integers of 8, 16, 32 bits, floats, 64 bits.
STORED = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8"}
STORED |= {12: "i8", 13: "u8"}
MOST_VARIABLES = 100_000


def numeric_variables(name: str, raw: bytes, wanted: Callable[[str], bool]) -> dict[str, Array]:
    """Read the wanted variables that are arrays of real numbers, the last of each name.

    Raises
    ------
    InputError
        Where the file is broken or holds too much.
    """
    if raw[124:128] not in (b"\x00\x01IM", b"\x01\x00MI"):
        raise InputError(f"{name}: is no MATLAB file of version 5 to 7; save it with -v7")
    order = "<" if raw[126:128] == b"IM" else ">"
    found: dict[str, Array] = {}
    try:
        for matrix in _matrices(name, raw, order):
            variable, shape, values = _described(matrix, order)
            if shape is not None and wanted(variable):
                found[variable] = _array(matrix, values, shape, order)
    except InputError:
        raise
    except (struct.error, zlib.error, UnicodeDecodeError, ValueError, KeyError):
        raise InputError(f"{name}: is no sound MATLAB file; save it again") from None
    return found


def _matrices(name: str, raw: bytes, order: str) -> Iterator[bytes]:
    """Contents of the variables, unpacked."""
    at, size, count = HEADER, 0, 0
    while at + 8 <= len(raw):
        kind, length = struct.unpack_from(order + "II", raw, at)
        content = raw[at + 8 : at + 8 + length]
        if len(content) < length:
            raise struct.error("cut short")
        if kind == COMPRESSED:
            packed = zlib.decompressobj()
            content = packed.decompress(content, LARGEST - size + 1)
        size, count = size + len(content), count + 1
        if size > LARGEST or count > MOST_VARIABLES:
            raise InputError(
                f"{name}: holds more than {LARGEST / 1e6:g} MB unpacked, the most that is read; "
                "save the points alone"
            )
        if kind == COMPRESSED:
            kind, content = struct.unpack_from(order + "I", content)[0], content[8:]
        if kind == MATRIX:
            yield content
        at += 8 + struct.unpack_from(order + "I", raw, at + 4)[0]


def _described(matrix: bytes, order: str) -> tuple[str, tuple[int, ...] | None, int]:
    """Name of a variable, its shape if an array of real numbers, and where its values begin."""
    _, flags, at = _element(matrix, 0, order)
    kind = struct.unpack_from(order + "I", flags)[0]
    is_complex = bool(kind & 0x0800)
    if kind & 0xFF not in NUMERIC or is_complex:
        return "", None, at
    _, sides, at = _element(matrix, at, order)
    shape = struct.unpack(f"{order}{len(sides) // 4}i", sides[: len(sides) // 4 * 4])
    _, text, at = _element(matrix, at, order)
    return text.decode("ascii"), shape, at


def _array(matrix: bytes, at: int, shape: tuple[int, ...], order: str) -> Array:
    """Take values column by column, stored in the smallest type that holds them."""
    kind, values, _ = _element(matrix, at, order)
    stored = np.frombuffer(values, order + STORED[kind])
    if min(shape) < 0:
        raise ValueError("negative sides")
    return stored.astype(np.float64).reshape(shape, order="F")


def _element(content: bytes, at: int, order: str) -> tuple[int, bytes, int]:
    """Kind and content of a data element, and where the next begins."""
    first = struct.unpack_from(order + "I", content, at)[0]
    if first >> 16:  # a small one, all in eight bytes
        length = first >> 16
        return first & 0xFFFF, content[at + 4 : at + 4 + min(length, 4)], at + 8
    length = struct.unpack_from(order + "I", content, at + 4)[0]
    end = at + 8 + length
    if end > len(content):
        raise struct.error("cut short")
    return first, content[at + 8 : end], end + -length % 8
