"""The one loop over candidates, whatever they are."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol, TypeVar

from bayescal.comparison.judged import Found, Judged, with_probabilities
from bayescal.comparison.key import Key
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store

Made = TypeVar("Made", bound=Judged, covariant=True)


class Candidate(Protocol[Made]):
    """A model of the observations, fitted but not yet sampled."""

    @property
    def key(self) -> Key:
        """Which it is."""
        ...

    def judge(self, store: Store, settings: Settings) -> Made:
        """Say what its evidence and its draws, of the store, say."""
        ...


def judge_all(
    candidates: Iterable[Candidate[Found]],
    store: Store,
    settings: Settings,
    tell: Callable[[Key], None] | None = None,
) -> tuple[Found, ...]:
    """Judge every candidate once: the one loop over models, whatever they are.

    `tell` is called with each key before its candidate is judged.
    """
    found = []
    for candidate in candidates:
        if tell is not None:
            tell(candidate.key)
        found.append(candidate.judge(store, settings))
    return with_probabilities(found)
