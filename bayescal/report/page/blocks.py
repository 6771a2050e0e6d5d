"""What a page is made of: values that the template only renders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from bayescal.report.grid import Table


@dataclass(frozen=True)
class Prose:
    """A paragraph.

    Attributes
    ----------
    text : str
        Plain text; the template escapes it.
    role : str
        ``""``, ``"note"`` (small), ``"caveat"`` (stressed) or ``"quote"`` (to copy).
    """

    kind: ClassVar[str] = "prose"
    text: str
    role: str = ""


@dataclass(frozen=True)
class Listing:
    """Sentences, a bullet each.

    Attributes
    ----------
    items : tuple of str
    role : str
        As of `Prose`; ``"numbered"`` counts them.
    """

    kind: ClassVar[str] = "listing"
    items: tuple[str, ...]
    role: str = ""


@dataclass(frozen=True)
class Facts:
    """Names and values beside each other, such as versions.

    Attributes
    ----------
    pairs : tuple of tuple of str
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
    caption : str
    table : Table
    notes : tuple of str
        Below the table, a sentence or two each.
    flagged : frozenset of int
        Rows that the reader should worry about.
    """

    kind: ClassVar[str] = "table"
    id: str
    caption: str
    table: Table
    notes: tuple[str, ...] = ()
    flagged: frozenset[int] = frozenset()

    @property
    def explained(self) -> tuple[tuple[str, str], ...]:
        """Heads of the columns with what they mean, where the head does not say all."""
        return tuple((c.shown, c.note) for c in self.table.columns if c.note)


@dataclass(frozen=True)
class Picture:
    """A figure.

    Attributes
    ----------
    id : str
        Unique on the page.
    source : str
        The picture itself as a data URI.
    alt : str
        What is to be seen, for those who can't.
    caption : str
    width, height : int
        CSS px.
    """

    kind: ClassVar[str] = "picture"
    id: str
    source: str
    alt: str
    caption: str
    width: int
    height: int


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
    """What was found on one axis, in large type.

    Attributes
    ----------
    axis : str
        Such as ``"r, of x/z"``.
    found : str
        Such as ``"order 4"``.
    standing : str
        How sure.
    """

    axis: str
    found: str
    standing: str


@dataclass(frozen=True)
class Answers:
    """The answers of all axes beside each other."""

    kind: ClassVar[str] = "answers"
    answers: tuple[Answer, ...]


@dataclass(frozen=True)
class Embedded:
    """A JSON document for machines, kept in the page.

    Attributes
    ----------
    id : str
        Of the script element that holds it.
    text : str
        JSON in which ``<`` is escaped.
    file : str
        Name to save it under.
    """

    kind: ClassVar[str] = "embedded"
    id: str
    text: str
    file: str


Block = Prose | Listing | Facts | Tabled | Picture | Details | Part | Answers | Embedded


@dataclass(frozen=True)
class Section:
    """A chapter of the page.

    Attributes
    ----------
    id : str
        Of its heading, for links.
    title : str
    lead : str
        One sentence that says what it answers.
    blocks : tuple of Block
    """

    id: str
    title: str
    lead: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Page:
    """Everything that the template needs.

    Attributes
    ----------
    title : str
    about : tuple of str
        What was analysed, a line each.
    warning : str
        Why the whole must not be trusted; empty where it can.
    sections : tuple of Section
    made_by : str
    """

    title: str
    about: tuple[str, ...]
    warning: str
    sections: tuple[Section, ...]
    made_by: str
