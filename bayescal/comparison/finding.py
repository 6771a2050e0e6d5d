"""A finding: what it says, and how much it should change the reader's mind."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum


class Severity(IntEnum):
    """How much a finding should change the reader's mind."""

    WRONG_MODEL = 0
    OVERTURNS = 1
    LIMITS = 2


@dataclass(frozen=True)
class Finding:
    """What stands against a verdict, or limits it.

    Attributes
    ----------
    kind : str
        Its module's name for it, such as ``"edge"``.
    severity : Severity
        All but one that only limits withhold the word "decided".
    text : str
        One sentence without a full stop.
    because : str
        In a few words, for the headline; empty where it withholds nothing.
    """

    kind: str
    severity: Severity
    text: str
    because: str = ""

    @property
    def withholds(self) -> bool:
        """Whether nothing can be called decided beside it."""
        return self.severity < Severity.LIMITS


def limits(kind: str, text: str) -> Finding:
    """Make a finding that limits the verdict."""
    return Finding(kind, Severity.LIMITS, text)


def wrong_model(kind: str, text: str, because: str) -> Finding:
    """Make a finding that the comparison is of models that are not the right ones."""
    return Finding(kind, Severity.WRONG_MODEL, text, because)


def overturns(kind: str, text: str, because: str) -> Finding:
    """Make a finding beside which nothing is decided."""
    return Finding(kind, Severity.OVERTURNS, text, because)


def ordered(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Put the gravest first, those alike in the order they were found; each sentence once."""
    unique = {found.text: found for found in findings}
    return tuple(sorted(unique.values(), key=lambda found: found.severity))
