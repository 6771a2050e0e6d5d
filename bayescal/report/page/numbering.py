"""Tables and figures of a page get numbers, and what is said once is not said again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

from bayescal.report.blocks import Block, Details, Part, Picture, Section, Tabled

Sentence = TypeVar("Sentence", str, tuple[str, str])


def numbered(sections: Iterable[Section]) -> tuple[Section, ...]:
    """Give what is cited numbers, in reading order; leave out what an earlier table says."""
    given = _Numbers()
    return tuple(
        replace(section, blocks=tuple(map(given.block, section.blocks))) for section in sections
    )


class _Numbers:
    """What has been numbered and said so far."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.said: dict[object, Tabled] = {}

    def block(self, block: Block) -> Block:
        if isinstance(block, Details | Part):
            return replace(block, blocks=tuple(map(self.block, block.blocks)))
        if isinstance(block, Picture):
            return replace(block, label=self.label("Figure"))
        return self.table(block) if isinstance(block, Tabled) else block

    def label(self, noun: str) -> str:
        self.counts[noun] += 1
        return f"{noun} {self.counts[noun]}"

    def table(self, table: Tabled) -> Tabled:
        """Give a table its number, and where another one says what its columns mean that one's."""
        table = replace(table, label=self.label("Table"))
        elsewhere: list[Tabled] = []
        columns = self.new(table, table.explained, elsewhere)
        notes = self.new(table, table.notes, elsewhere)
        places = {(found.id, found.label) for found in elsewhere}
        first = sorted(places, key=lambda place: int(place[1].split()[1]))
        return replace(table, columns=columns, notes=notes, elsewhere=tuple(first))

    def new(
        self, table: Tabled, sentences: Iterable[Sentence], elsewhere: list[Tabled]
    ) -> tuple[Sentence, ...]:
        """Keep what was not said before; collect where the rest was."""
        found = []
        for sentence in sentences:
            before = self.said.setdefault(sentence, table)
            if before is table:
                found.append(sentence)
            else:
                elsewhere.append(before)
        return tuple(found)
