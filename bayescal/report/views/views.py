"""The views that every kind of result offers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Blocks, Part, Section

Result = TypeVar("Result")
Chapters = Mapping[str, Callable[[Result], Section | None]]


def axis_title(axis: AxisComparison) -> str:
    """Name an axis with its regressor."""
    return f"{axis.data.axis} as a polynomial of {axis.data.regressor}"


def nothing(_: Comparison, /) -> Blocks:
    """Give no blocks."""
    return ()


def unmentioned(_: object, /) -> Iterable[str]:
    """Give no sentences."""
    return ()


@dataclass(frozen=True)
class Topic:
    """What is said of a comparison of orders under one heading, most of it axis by axis.

    Attributes
    ----------
    id, title, lead : str
        As of `Section`.
    of_axis : callable
        Blocks of one axis; none where it has nothing to show.
    before, after : callable
        Blocks of all axes together, around those.
    """

    id: str
    title: str
    lead: str
    of_axis: Callable[[Comparison, AxisComparison], Blocks]
    before: Callable[[Comparison], Blocks] = nothing
    after: Callable[[Comparison], Blocks] = nothing

    def section(self, comparison: Comparison) -> Section | None:
        """Make the chapter; None where there is nothing to show."""
        parts = tuple(
            Part(axis_title(axis), blocks)
            for axis in comparison.axes.values()
            if (blocks := self.of_axis(comparison, axis))
        )
        blocks = (*self.before(comparison), *parts, *self.after(comparison))
        return Section(self.id, self.title, self.lead, blocks) if blocks else None


@dataclass(frozen=True)
class Views(Generic[Result]):
    """How results of one kind are shown.

    Attributes
    ----------
    title : callable
        Heads a page.
    about : callable
        What was analysed, a line each.
    brief : callable
        Everything that its command prints.
    full : callable
        The same with everything there is to say.
    headlines : callable
        What was found, in a line or a few.
    sections : mapping
        Chapters of a page by their ids, in reading order; each is made, or is None where there
        is nothing to show.
    unsound : str
        What to say of a result that must not be trusted.
    appendix : mapping
        Those that follow the chapters of results shown beside it.
    methods : callable, optional
        Makes the chapter that says how it was done, of the result, what is said of those shown
        beside it, and the provenance of its document.
    beside : callable
        Sentences for the methods of a result that it is shown beside.
    """

    title: Callable[[Result], str]
    about: Callable[[Result], list[str]]
    brief: Callable[[Result], Blocks]
    full: Callable[[Result], Blocks]
    headlines: Callable[[Result], list[str]]
    sections: Chapters[Result]
    unsound: str
    appendix: Chapters[Result] = field(default_factory=dict)
    methods: Callable[[Result, Iterable[str], Mapping[str, Any]], Section] | None = None
    beside: Callable[[Result], Iterable[str]] = unmentioned
