"""Values as a file and back: to the last bit, of the types asked for, and nothing else.

Truth: the values themselves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from bayescal.arrays import Array, frozen
from bayescal.encoding import Encoded, encoded


@dataclass(frozen=True, eq=False)
class Inner:
    numbers: Array
    names: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Outer:
    inner: Inner
    by_order: dict[int, float]
    both: tuple[Inner, int]
    several: tuple[Inner, ...]
    missing: Inner | None
    flag: bool


VALUE = Outer(
    Inner(frozen([[0.1, math.nan], [-math.inf, 5e-324]]), ("é", "")),
    {1: 0.1, 12: math.inf},
    (Inner(frozen([])), 3),
    (Inner(frozen([1.0])), Inner(frozen([2.0, 3.0]))),
    None,
    True,
)


def again(value: object, kind: object) -> Outer:
    return Encoded.parse(encoded({"other": 1.5, "value": value})).value("value", kind)


def test_values_come_back_to_the_last_bit() -> None:
    found = again(VALUE, Outer)
    assert found.inner.numbers.tobytes() == VALUE.inner.numbers.tobytes()
    assert found.inner.numbers.shape == (2, 2)
    assert found.inner.names == VALUE.inner.names
    assert found.by_order == VALUE.by_order
    assert found.both[0].numbers.shape == (0,)
    assert found.both[1] == 3
    assert [one.numbers.tolist() for one in found.several] == [[1.0], [2.0, 3.0]]
    assert (found.missing, found.flag) == (None, True)
    with pytest.raises(ValueError, match="read-only"):
        found.inner.numbers[0, 0] = 1.0


@pytest.mark.parametrize("value", [3, "x", 1.5, None])
def test_a_union_of_several_types_comes_back(value: object) -> None:
    kind = int | tuple[int, ...] | float | str | None
    assert (found := again(value, kind)) == value
    assert type(found) is type(value)
    with pytest.raises(ValueError, match="belongs"):
        again(True, kind)


def test_a_union_with_a_dataclass_comes_back() -> None:
    assert again(VALUE.inner, int | Inner).names == VALUE.inner.names


def test_the_same_values_give_the_same_bytes() -> None:
    assert encoded({"value": VALUE}) == encoded({"value": again(VALUE, Outer)})


@pytest.mark.parametrize(
    ("value", "kind", "words"),
    [
        (VALUE, Inner, "inner"),
        (1.5, int, "1.5 where a int belongs"),
        (True, float, "True where a float belongs"),
        ("x", Array, "value"),
        ((1, 2, 3), tuple[int, int], "3 values where 2 belong"),
        (VALUE.inner, tuple[int, ...], "value"),
        (None, Inner, "value"),
    ],
)
def test_what_is_of_another_type_is_refused(value: object, kind: object, words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        again(value, kind)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("raw", [b"", b"PK\x03\x04", b"{}", encoded({"value": VALUE})[:-40]])
def test_a_damaged_file_is_refused(raw: bytes) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        Encoded.parse(raw)


def test_only_what_comes_back_is_written() -> None:
    for value in (object(), [1], np.array([1], dtype=np.int64)):
        with pytest.raises(TypeError):
            encoded({"value": value})


def test_an_array_beyond_the_file_is_refused() -> None:
    found = Encoded({"value": {"at": 0, "shape": [3]}}, np.zeros(2))
    with pytest.raises(ValueError, match="reshape"):
        found.value("value", Array)
