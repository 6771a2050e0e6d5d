"""Frozen values as one small file, and back by their types: nothing in a file says what to build.

Numbers of all arrays stand in one array (npz, read without pickle), all else as JSON beside it;
dataclasses are objects by the names of their fields. Reading is led by a type that the caller
states, so that a file from elsewhere can't make anything else.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cache
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from bayescal.arrays import Array, from_npz, to_npz

NUMBERS = "numbers"


def encoded(values: Mapping[str, Any]) -> bytes:
    """Encode values by name; the same values give the same bytes.

    Parameters
    ----------
    values : mapping of str to Any
        Numbers, texts, None, arrays of float64, tuples, dictionaries by text or integer, and
        dataclasses of these.
    """
    parts: list[Array] = []
    head = {name: _plain(value, parts) for name, value in values.items()}
    numbers = np.concatenate([np.empty(0), *(part.ravel() for part in parts)])
    return to_npz(head, {NUMBERS: numbers})


def _plain(value: Any, parts: list[Array]) -> Any:
    """Make JSON of a value; the numbers of its arrays go to the end of `parts`."""
    if isinstance(value, np.ndarray):
        if value.dtype != np.float64:
            raise TypeError(f"an array of {value.dtype}")
        at = sum(part.size for part in parts)
        parts.append(value)
        return {"at": at, "shape": value.shape}
    if isinstance(value, np.generic):
        return value.item()
    if dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value) if field.init]
        return {name: _plain(getattr(value, name), parts) for name in names}
    if isinstance(value, Mapping):
        return {str(key): _plain(one, parts) for key, one in value.items()}
    if isinstance(value, tuple):
        return [_plain(one, parts) for one in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a {type(value).__name__}")


@dataclasses.dataclass(frozen=True, eq=False)
class Encoded:
    """What a file holds, each value made when it is asked for."""

    values: Mapping[str, Any]
    numbers: Array

    @classmethod
    def parse(cls, raw: bytes) -> Encoded:
        """Read what `encoded` wrote.

        Raises
        ------
        ValueError
            Where it is no such file, or is damaged.
        """
        values, arrays = from_npz(raw)
        numbers = arrays.get(NUMBERS)
        if not isinstance(values, dict) or numbers is None or numbers.dtype != np.float64:
            raise ValueError("holds something else")
        return cls(values, numbers)

    def __contains__(self, name: str) -> bool:
        return name in self.values

    def value(self, name: str, kind: Any) -> Any:
        """Make a value of the type that it was of.

        Parameters
        ----------
        kind : type
            ``float``, ``Array``, ``tuple[int, ...]``, a dataclass, ``X | None`` and so on.

        Raises
        ------
        ValueError
            Where what stands there is of another type.
        """
        try:
            return self._made(self.values[name], kind)
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"{name}: {' '.join(str(error).split())}") from None

    def _made(self, found: Any, kind: Any) -> Any:
        origin, inner = get_origin(kind), get_args(kind)
        if origin in (Union, UnionType):
            return self._one_of(found, inner)
        if kind == Array:
            return self._array(found["at"], tuple(found["shape"]))
        if origin is tuple:
            return self._tuple(found, inner)
        if origin is dict:
            return {inner[0](key): self._made(one, inner[1]) for key, one in found.items()}
        if isinstance(kind, type) and dataclasses.is_dataclass(kind):
            hints = _hints(kind)
            return kind(**{key: self._made(one, hints[key]) for key, one in found.items()})
        if kind is float and isinstance(found, int) and not isinstance(found, bool):
            return float(found)
        if type(found) is not kind:
            raise TypeError(f"{found!r} where a {kind.__name__} belongs")
        return found

    def _one_of(self, found: Any, kinds: tuple[Any, ...]) -> Any:
        if found is None and type(None) in kinds:
            return None
        *others, last = (kind for kind in kinds if kind is not type(None))
        for kind in others:
            try:
                return self._made(found, kind)
            except (KeyError, TypeError, AttributeError):
                continue
        return self._made(found, last)

    def _tuple(self, found: list[Any], inner: tuple[Any, ...]) -> tuple[Any, ...]:
        kinds = inner[:1] * len(found) if inner[1:] == (...,) else inner
        if len(kinds) != len(found):
            raise TypeError(f"{len(found)} values where {len(kinds)} belong")
        return tuple(self._made(one, kind) for one, kind in zip(found, kinds, strict=True))

    def _array(self, at: int, shape: tuple[int, ...]) -> Array:
        out = self.numbers[at : at + int(np.prod(shape, dtype=int))].reshape(shape)
        out.setflags(write=False)
        return out


@cache
def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind)
