"""What a result document must hold for its run to be reopened, and what must come out the same.

A shape is written as the document is: a mapping by key, a list of one shape for all its items, a
type or several, or one of the values below.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isclose
from numbers import Real
from typing import Any

NUMBER = (int, float, type(None))
# The closed form is good to this many nats, on any machine (docs/method.md).
NATS = 1e-6
# Beyond that, rounding of sums over many points, as a share of the number.
ROUNDING = 1e-10


@dataclass(frozen=True)
class Maybe:
    """What may be null, and what it must hold where it is not."""

    shape: Any


@dataclass(frozen=True)
class Each:
    """A mapping that is not empty, each of its values of one shape.

    Attributes
    ----------
    keys : tuple of str
        Those it may have; any where empty.
    named : str
        What a key is, for messages, such as ``"order"``; nothing where the key says it.
    """

    shape: Any
    keys: tuple[str, ...] = ()
    named: str = ""


@dataclass(frozen=True)
class Same:
    """A value that must come out the same when it is computed again.

    Attributes
    ----------
    words : str
        What it is, for messages.
    within : float
        By how much a number may differ.
    unit : str
        The number beside it that `within` is a share of; nothing where it is absolute.
    now : str
        Where the other number comes from.
    """

    words: str
    kind: Any = NUMBER
    within: float = NATS
    unit: str = ""
    now: str = "now"


# What a named item of a list is called in messages; the first of these that it has.
NAMES = {"name": "{}", "label": "point {}", "order": "order {}"}


def misshapen(found: Any, wanted: Any, place: str = "") -> str | None:
    """Name the first thing that a value lacks or has of another kind; None where it fits."""
    if isinstance(wanted, Same):
        wanted = wanted.kind
    if isinstance(wanted, Maybe):
        return None if found is None else misshapen(found, wanted.shape, place)
    if isinstance(wanted, Each):
        if not isinstance(found, Mapping) or not found:
            return place
        if wanted.keys and not set(found) <= set(wanted.keys):
            return place
        parts = [(value, wanted.shape, key) for key, value in found.items()]
    elif isinstance(wanted, Mapping):
        if not isinstance(found, Mapping):
            return place
        parts = [(found.get(key, ...), shape, key) for key, shape in wanted.items()]
    elif isinstance(wanted, list):
        if not isinstance(found, list) or not found:
            return place
        parts = [(item, wanted[0], str(i)) for i, item in enumerate(found)]
    else:
        return None if isinstance(found, wanted) else place
    misfits = (misshapen(part, shape, f"{place}.{key}".lstrip(".")) for part, shape, key in parts)
    return next((place for place in misfits if place is not None), None)


def disagreement(kept: Any, made: Any, shape: Any) -> str | None:
    """Name the first value that a document and the one just made again don't share."""
    return next(_disagreements(kept, made, shape, ()), None)


def _disagreements(kept: Any, made: Any, shape: Any, place: tuple[str, ...]) -> Iterator[str]:
    if isinstance(shape, Maybe):
        if (kept is None) != (made is None):
            was, now = ("nothing", "something") if kept is None else ("something", "nothing")
            yield f"the {_placed(place)} is {was} in the run but {now} now"
        elif kept is not None:
            yield from _disagreements(kept, made, shape.shape, place[:-1])
    elif isinstance(shape, Each):
        wanted = {f"{shape.named} {key}".strip(): (value, key) for key, value in kept.items()}
        yield from _others(place, list(kept), list(made))
        for name, (value, key) in wanted.items():
            inner = *place[:-1], name
            if isinstance(shape.shape, Same):
                yield from _unlike(kept, made, key, shape.shape, inner)
            else:
                yield from _disagreements(value, made.get(key), shape.shape, inner)
    elif isinstance(shape, list) and isinstance(shape[0], Mapping):
        names, again = ([_name(item, i) for i, item in enumerate(x)] for x in (kept, made))
        yield from _others(place, names, again)
        pairs = dict(zip(again, made, strict=True))
        # In the order of the run: equally probable models may change places.
        news = made if names == again else [pairs.get(name) for name in names]
        for name, old, new in zip(names, kept, news, strict=True):
            yield from _disagreements(old, new, shape[0], (*place[:-1], name))
    elif isinstance(shape, Mapping):
        for key, part in shape.items():
            if isinstance(part, Same):
                yield from _unlike(kept, made, key, part, place)
            elif isinstance(part, Mapping):
                yield from _disagreements(kept[key], made[key], part, place)
            elif isinstance(part, Maybe | Each | list):
                yield from _disagreements(kept[key], made[key], part, (*place, key))


def _unlike(
    kept: Mapping[str, Any], made: Mapping[str, Any], key: str, wanted: Same, place: tuple[str, ...]
) -> Iterator[str]:
    was, now = kept[key], made[key]
    within = wanted.within * (abs(kept[wanted.unit]) if wanted.unit else 1.0)
    numbers = isinstance(was, Real) and isinstance(now, Real)
    if not (was == now or (numbers and isclose(was, now, rel_tol=ROUNDING, abs_tol=within))):
        yield f"the {_placed((*place, wanted.words))} is {was} in the run but {now} {wanted.now}"


def _others(place: tuple[str, ...], kept: list[str], made: list[str]) -> Iterator[str]:
    """Say which items a list of the run has that the one made now has not, or the reverse."""
    if sorted(kept) != sorted(made):
        odd = sorted(set(kept) ^ set(made)) or ["one stands there twice"]
        yield f"the {_placed(place)} of the run are not those computed now: {odd[0]}"


def _name(item: Mapping[str, Any], number: int) -> str:
    """Call an item of a list by its name, or its number."""
    words = (form.format(item[key]) for key, form in NAMES.items() if key in item)
    return next(words, str(number))


def _placed(place: Sequence[str]) -> str:
    """Where a value stands, from the inside out."""
    return " of ".join(reversed(place))
