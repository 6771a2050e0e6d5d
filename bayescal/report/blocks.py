"""What a view of a result is made of: values that a terminal and a page lay out, each its way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from bayescal.report.table import Table


@dataclass(frozen=True)
class Prose:
    """A paragraph.

    Attributes
    ----------
    text : str
        Plain; outlets escape it.
    role : str
        ``""``, ``"note"`` (small) or ``"quote"`` (to copy).
    lead : str
        Stressed words in front of it.
    """

    kind: ClassVar[str] = "prose"
    text: str
    role: str = ""
    lead: str = ""


@dataclass(frozen=True)
class Listing:
    """Sentences, one below the other.

    Attributes
    ----------
    role : str
        ``""``; ``"caveat"`` or ``"concern"`` (stressed); ``"numbered"``; ``"about"`` (heads
        what is printed, as the lines below its title head a page).
    """

    kind: ClassVar[str] = "listing"
    items: tuple[str, ...]
    role: str = ""


@dataclass(frozen=True)
class Facts:
    """Names and values beside each other, such as versions.

    Attributes
    ----------
    verbatim : bool
        Whether the values are written by machines (file names, commands, hashes).
    """

    kind: ClassVar[str] = "facts"
    pairs: tuple[tuple[str, str], ...]
    verbatim: bool = False


@dataclass(frozen=True)
class Tabled:
    """A table with its caption and what its columns mean.

    Attributes
    ----------
    id : str
        Unique on the page.
    notes : tuple of str
        Below the table, a sentence or two each.
    legend : tuple of str
        The same, of what a page says of the columns.
    flagged : frozenset of int
        Rows that the reader should worry about.
    folded : str
        What a page shows in its place until asked for it; empty: the table itself.
    label : str
        To cite it by, such as ``"Table 3"``; a page gives it.
    columns : tuple of tuple of str or None
        Those of `explained` that no earlier table of the page explains; None: all.
    elsewhere : tuple of tuple of str
        Ids and labels of tables that explain the others, and whose notes hold here.
    """

    kind: ClassVar[str] = "table"
    id: str
    caption: str
    table: Table
    notes: tuple[str, ...] = ()
    legend: tuple[str, ...] = ()
    flagged: frozenset[int] = frozenset()
    folded: str = ""
    label: str = ""
    columns: tuple[tuple[str, str], ...] | None = None
    elsewhere: tuple[tuple[str, str], ...] = ()

    @property
    def explained(self) -> tuple[tuple[str, str], ...]:
        """Heads of the columns with what they mean, where the head does not say all."""
        return tuple((c.shown, c.note) for c in self.table.columns if c.note)


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure to draw, where there is room for one.

    Attributes
    ----------
    name : str
        Of its kind, as ``bayescal plot`` takes it.
    result : Any
        What it is drawn of.
    axis, order
        Of which; None: as the kind has it.
    dpi : float or None
        Of the dots of a figure that is known to be too crowded for lines.
    """

    kind: ClassVar[str] = "figure"
    name: str
    result: Any
    caption: str
    axis: str | None = None
    order: int | None = None
    dpi: float | None = None


@dataclass(frozen=True)
class Picture:
    """A figure that a page has drawn.

    Attributes
    ----------
    id : str
        Unique on the page.
    source : str
        The picture itself as a data URI.
    alt : str
        What is to be seen, for those who can't.
    width, height : int
        CSS px.
    label : str
        To cite it by, such as ``"Figure 2"``; a page gives it.
    """

    kind: ClassVar[str] = "picture"
    id: str
    source: str
    alt: str
    caption: str
    width: int
    height: int
    label: str = ""


@dataclass(frozen=True)
class Details:
    """Blocks that are folded away until asked for."""

    kind: ClassVar[str] = "details"
    summary: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Part:
    """Blocks under a heading of their own, such as one axis."""

    kind: ClassVar[str] = "part"
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Answer:
    """What was found, in large type.

    Attributes
    ----------
    of : str
        Of what, such as ``"r, in x/z"``.
    found : str
        What, in a word or two.
    standing : str
        How sure.
    doubts : tuple of str
        What could be wrong, in a few words each.
    """

    of: str
    found: str
    standing: str
    doubts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Answers:
    """Answers beside each other."""

    kind: ClassVar[str] = "answers"
    answers: tuple[Answer, ...]


@dataclass(frozen=True)
class Embedded:
    """A JSON document for machines, kept in the page.

    Attributes
    ----------
    id : str
        Of the element that holds it.
    text : str
        JSON in which ``<`` is escaped.
    file : str
        Name to save it under.
    """

    kind: ClassVar[str] = "embedded"
    id: str
    text: str
    file: str


Block = Prose | Listing | Facts | Tabled | Figure | Picture | Details | Part | Answers | Embedded
Blocks = tuple[Block, ...]


@dataclass(frozen=True)
class Section:
    """A chapter: its heading, one sentence that says what it answers, and its blocks.

    Attributes
    ----------
    id : str
        Of its heading, for links.
    """

    id: str
    title: str
    lead: str
    blocks: Blocks


def listed(items: Sequence[str], role: str = "") -> Blocks:
    """Give a listing, or nothing where there is no item."""
    return (Listing(tuple(items), role),) if items else ()
