"""What every verdict has: a headline, what stands against it, and the word "decided" or not."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Self

from bayescal.comparison.findings.finding import Finding, ordered
from bayescal.markup import bullets, paragraph


@dataclass(frozen=True, kw_only=True, repr=False)
class Verdict(ABC):
    """What to conclude of candidates, what stands against it, and how that is said.

    Attributes
    ----------
    plausible : tuple
        Smallest set of candidates, by falling probability, that reaches 0.95.
    chances : tuple of float
        Probabilities of the plausible candidates.
    findings : tuple of Finding
        What stands against the verdict or limits it, the gravest first.
    sentences : tuple of str
        What follows the headline.
    """

    plausible: tuple[Any, ...]
    chances: tuple[float, ...]
    findings: tuple[Finding, ...]
    sentences: tuple[str, ...]

    @property
    @abstractmethod
    def headline(self) -> str:
        """The outcome in a sentence."""

    @property
    @abstractmethod
    def recommended(self) -> str:
        """Name what is recommended."""

    @property
    @abstractmethod
    def standing(self) -> str:
        """How what is recommended stands, in a few words: what the headline says, shorter."""

    @property
    def withheld(self) -> tuple[str, ...]:
        """Why nothing can be called decided, in a few words each."""
        return tuple(dict.fromkeys(f.because for f in self.findings if f.withholds))

    @property
    def decided(self) -> bool:
        """Whether one candidate alone is plausible, and nothing stands against the comparison."""
        return len(self.plausible) == 1 and not self.withheld

    @property
    def caveats(self) -> tuple[str, ...]:
        """The findings' sentences, the gravest first."""
        return tuple(f.text for f in self.findings)

    @property
    def text(self) -> str:
        """One paragraph: the headline, then what supports it."""
        return " ".join((self.headline, *self.sentences))

    def with_findings(self, more: Iterable[Finding], *sentences: str) -> Self:
        """Give the verdict with more findings, and more sentences behind it."""
        found = ordered((*self.findings, *more))
        said = (*self.sentences, *(s for s in sentences if s))
        return replace(self, findings=found, sentences=said)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.text}>"

    def _repr_html_(self) -> str:
        """Show the verdict in a notebook."""
        return paragraph(self.text) + bullets("Caveats", self.caveats)
