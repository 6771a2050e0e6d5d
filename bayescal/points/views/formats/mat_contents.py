"""What a MATLAB file holds, looked at before anything is made of it.

scipy unpacks whatever a file says. This walks the elements of a file (MathWorks, "MAT-File
Format", level 5), unpacks no more than a stated size, and names the variables that are arrays of
numbers and no larger than their bytes.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

from bayescal.errors import InputError

LARGEST = 256_000_000  # bytes of all variables, unpacked
HEADER = 128
MATRIX, COMPRESSED = 14, 15
INT8, INT32, UINT32 = 1, 5, 6
NUMERIC = range(6, 16)  # double, single, and integers of all widths
MOST_VARIABLES = 100_000


def numeric_variables(name: str, raw: bytes) -> list[str]:
    """Names of the variables that hold plain arrays of numbers.

    Raises
    ------
    InputError
        Where the file is broken or holds too much.
    """
    if raw[124:128] not in (b"\x00\x01IM", b"\x01\x00MI"):
        raise InputError(f"{name}: is no MATLAB file of version 5 to 7; save it with -v7")
    order = "<" if raw[126:128] == b"IM" else ">"
    found = []
    try:
        for matrix in _matrices(name, raw, order):
            variable = _variable(matrix, order)
            if variable is not None:
                found.append(variable)
    except (struct.error, zlib.error, UnicodeDecodeError, IndexError):
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


def _variable(matrix: bytes, order: str) -> str | None:
    """Name of a variable, where it is an array of numbers that its bytes can hold."""
    _, flags, at = _element(matrix, 0, order)
    kind = struct.unpack_from(order + "I", flags)[0]
    is_complex = bool(kind & 0x0800)
    _, sides, at = _element(matrix, at, order)
    shape = struct.unpack(f"{order}{len(sides) // 4}i", sides[: len(sides) // 4 * 4])
    _, text, at = _element(matrix, at, order)
    count = 1
    for side in shape:
        count *= max(side, 0)
    if kind & 0xFF not in NUMERIC or is_complex or len(shape) > 4 or count > len(matrix):
        return None
    return text.decode("ascii")


def _element(content: bytes, at: int, order: str) -> tuple[int, bytes, int]:
    """Kind and content of a data element, and where the next begins."""
    first = struct.unpack_from(order + "I", content, at)[0]
    if first >> 16:  # a small one, all in eight bytes
        length = first >> 16
        return first & 0xFFFF, content[at + 4 : at + 4 + min(length, 4)], at + 8
    length = struct.unpack_from(order + "I", content, at + 4)[0]
    end = at + 8 + length
    return first, content[at + 8 : end], end + -length % 8
