"""What every verdict has: a headline, what stands against it, and the word "decided" or not."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

from bayescal.comparison.finding import Finding, ordered
from bayescal.markup import bullets, paragraph
from bayescal.rounding import counted, percent

DECIDED = "decided at 95%"


@dataclass(frozen=True, kw_only=True, repr=False)
class Verdict(ABC):
    """What to conclude of candidates, what stands against it, and how that is said.

    Attributes
    ----------
    compared : int
        Number of candidates.
    plausible : tuple
        Smallest set of candidates, by falling probability, that reaches 0.95.
    chances : tuple of float
        Probabilities of the plausible candidates.
    findings : tuple of Finding
        What stands against the verdict or limits it, the gravest first.
    sentences : tuple of str
        What follows the headline.
    """

    noun: ClassVar[str] = "one"  # what a candidate is called
    nouns: ClassVar[str] = "ones"

    compared: int
    plausible: tuple[Any, ...]
    chances: tuple[float, ...]
    findings: tuple[Finding, ...]
    sentences: tuple[str, ...]

    @property
    @abstractmethod
    def recommended(self) -> str:
        """Name what is recommended."""

    @property
    def subject(self) -> str:
        """What is recommended, as a sentence begins with it."""
        return self.recommended[0].upper() + self.recommended[1:]

    @property
    def others(self) -> str:
        """The other plausible candidates with their probabilities; empty where there are none."""
        named = zip(self.plausible[1:], self.chances[1:], strict=True)
        return ", ".join(f"{name} ({percent(chance)})" for name, chance in named)

    @property
    def standing(self) -> str:
        """How what is recommended stands, in a few words; `withheld` says why."""
        if self.compared == 1:
            return "the only one compared"
        chance = f"{percent(self.chances[0])} probable"
        if self.withheld:
            return f"{chance} among those compared; not decided"
        return f"{chance}; {self._open_briefly() if self.others else DECIDED}"

    @property
    def headline(self) -> str:
        """The outcome in a sentence."""
        withheld = _listed(self.withheld)
        if self.compared == 1:
            only = f"{self.subject} is the only {self.noun} compared"
            return f"{only}; {withheld}." if withheld else f"{only}."
        open_ = f"{self.others} can't be excluded at 95%" if self.others else ""
        chance = percent(self.chances[0])
        if withheld:
            why = ", and ".join(filter(None, (open_, withheld)))
            return f"{self.subject} is the best of those compared, {chance}; not decided: {why}."
        lead = f"{self.subject} is the most probable, {chance}"
        return f"{self._open(lead, open_)}." if open_ else f"{lead}; {DECIDED}."

    @property
    def not_excluded(self) -> str:
        """What else is plausible, in a few words; empty where nothing is."""
        if not self.others:
            return ""
        first, *more = (str(name) for name in self.plausible[1:])
        if not more:
            return f"{self.noun} {first} not excluded"
        rest = more[0] if len(more) == 1 else counted(len(more), "other")
        return f"{self.nouns} {first} and {rest} not excluded"

    def _open_briefly(self) -> str:
        """Say in a few words how matters stand where others are plausible."""
        return self.not_excluded

    def _open(self, lead: str, open_: str) -> str:
        """Say how matters stand where others are plausible, which `open_` says."""
        return f"{lead}; not decided: {open_}"

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


def _listed(parts: Sequence[str]) -> str:
    """Join clauses with commas, the last with "and"."""
    *some, last = parts or ("",)
    return f"{', '.join(some)}, and {last}" if some else last
