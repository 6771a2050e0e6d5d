"""The kinds of figure: what each shows, what it needs, how it is drawn and described."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar, cast

from bayescal.errors import InputError

if TYPE_CHECKING:  # the command's help lists the kinds without paying for matplotlib
    from matplotlib.figure import Figure

    from bayescal.comparison.families.results import FamilyComparison
    from bayescal.comparison.results import Comparison
    from bayescal.report.figures.subject import Subject

Drawn = TypeVar("Drawn", contravariant=True)


class FigureModule(Protocol, Generic[Drawn]):
    """What the module of a kind offers.

    Both raise `InputError`, with the reason in words, where there is nothing to draw.
    """

    def draw(self, subject: Drawn, /) -> Figure:
        """Draw the figure."""
        ...

    def alt_text(self, subject: Drawn, /) -> str:
        """Say in a sentence or two what is to be seen, with its numbers."""
        ...


@dataclass(frozen=True)
class FigureKind:
    """One kind of figure.

    Attributes
    ----------
    name : str
        As the command line takes it; also its module in this folder.
    summary : str
        One line.
    one_axis : bool
        Whether it is of one axis, which must be named where there are two; else of all
        axes, or of the one named.
    one_order : bool
        Whether it is of one order; else it shows every order compared.
    needs_defence : bool
        Whether it shows what only a defended comparison holds.
    """

    name: str
    summary: str
    one_axis: bool
    one_order: bool
    needs_defence: bool = False

    def draw(
        self, comparison: Comparison, axis: str | None = None, order: int | None = None
    ) -> Figure:
        """Draw it.

        Parameters
        ----------
        comparison : Comparison
        axis : str, optional
            Of `comparison.axes`; may be left out where there is only one, and for a
            figure of all axes.
        order : int, optional
            One of those compared; the chosen one by default.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            Where axis or order are missing, foreign or not taken, or there is nothing
            to draw; says why.
        """
        subject = self._subject(comparison, axis, order)
        from bayescal.report.figures.style import styled

        with styled():
            return self._module.draw(subject)

    def alt_text(
        self, comparison: Comparison, axis: str | None = None, order: int | None = None
    ) -> str:
        """Describe it for those who can't see it; parameters and errors as `draw`."""
        return self._module.alt_text(self._subject(comparison, axis, order))

    @property
    def _module(self) -> FigureModule[Subject]:
        return cast("FigureModule[Subject]", _module(self.name))

    def _subject(self, comparison: Comparison, axis: str | None, order: int | None) -> Subject:
        from bayescal.report.figures.subject import Subject

        names = ", ".join(comparison.axes)
        if order is not None and not self.one_order:
            raise InputError(f"{self.name} shows every order; leave out the order")
        if axis is not None and axis not in comparison.axes:
            raise InputError(f"axis {axis} was not compared; axes: {names}")
        if axis is None and len(comparison.axes) == 1:
            (axis,) = comparison.axes
        if axis is None and (self.one_axis or order is not None):
            raise InputError(f"{self.name} needs an axis, one of {names}")
        if self.needs_defence and any(a.defence is None for a in comparison.axes.values()):
            raise InputError(f"{self.name} needs a defended comparison (defend=True, --defend)")
        subject = Subject(comparison, axis, order)
        if order is not None:
            subject.check_order()
        return subject


@dataclass(frozen=True)
class FamilyFigureKind:
    """One kind of figure of a comparison across families.

    Attributes
    ----------
    name, summary : str
        As of `FigureKind`.
    """

    name: str
    summary: str

    def draw(self, found: FamilyComparison) -> Figure:
        """Draw it.

        Raises
        ------
        InputError
            Where there is nothing to draw; says why.
        """
        from bayescal.report.figures.style import styled

        with styled():
            return self._module.draw(found)

    def alt_text(self, found: FamilyComparison) -> str:
        """Describe it for those who can't see it."""
        return self._module.alt_text(found)

    @property
    def _module(self) -> FigureModule[FamilyComparison]:
        return cast("FigureModule[FamilyComparison]", _module(self.name))


def _module(name: str) -> object:
    return import_module(f"bayescal.report.figures.{name}")


_LIST = (
    FigureKind("verdict", "probability of each order, all axes", False, False),
    FigureKind("joint", "probability of each pair of orders", False, False),
    FigureKind("evidence", "log evidence of each order over fixed tau", True, False),
    FigureKind("loo", "leave-one-out differences, with errors", True, False, needs_defence=True),
    FigureKind("bootstrap", "share of resamples each order wins", True, False, needs_defence=True),
    FigureKind("residuals", "residuals over the regressor", True, True),
    FigureKind("other", "residuals over the other axis's regressor", True, True),
    FigureKind("image", "residuals over the image plane, as arrows", False, True),
    FigureKind("qq", "normal quantiles of the residuals", True, True),
    FigureKind("curve", "fitted curve and data less the straight part", True, True),
    FigureKind("corner", "posterior of all parameters, draws and closed form", True, True),
    FigureKind("trace", "chains and their ranks", True, True),
    FigureKind("autocorrelation", "autocorrelation of the chains", True, True),
)
KINDS: dict[str, FigureKind] = {kind.name: kind for kind in _LIST}
_FAMILY_LIST = (
    FamilyFigureKind("models", "families: log evidence of every model of r and c"),
    FamilyFigureKind("vectors", "families: residuals of the best models over the image"),
    FamilyFigureKind("position", "families: camera position against the stated one"),
    FamilyFigureKind("correlation", "families: correlations of the parameters"),
)
FAMILY_KINDS: dict[str, FamilyFigureKind] = {kind.name: kind for kind in _FAMILY_LIST}


def plot(
    comparison: Comparison | FamilyComparison,
    kind: str,
    *,
    axis: str | None = None,
    order: int | None = None,
) -> Figure:
    """Draw one kind of figure of a comparison.

    Parameters
    ----------
    comparison : Comparison or FamilyComparison
        From `compare`, `compare_polynomials`, `fit`, `compare_families`, `fit_family` or
        `open_run`.
    kind : str
        Of families one of ``FAMILY_KINDS``: ``"models"``, ``"vectors"``, ``"position"``,
        ``"correlation"``. Of orders one of ``KINDS``: ``"verdict"``, ``"joint"``,
        ``"evidence"``, ``"loo"``, ``"bootstrap"``, ``"residuals"``, ``"other"``,
        ``"image"``, ``"qq"``, ``"curve"``, ``"corner"``, ``"trace"``, ``"autocorrelation"``.
    axis : str, optional
        ``"r"``, ``"c"`` or ``"y"``; may be left out where there is only one, and for
        a figure of all axes. Families have none.
    order : int, optional
        One of those compared; the recommended one by default. Families have none.

    Returns
    -------
    matplotlib.figure.Figure
        Not known to pyplot; save it with its ``savefig``.

    Raises
    ------
    InputError
        Where there is no such kind, axis or order, or nothing to draw; says why.
    """
    from bayescal.comparison.families.results import FamilyComparison

    if isinstance(comparison, FamilyComparison):
        _check_kind(kind, FAMILY_KINDS, "of families")
        if axis is not None or order is not None:
            raise InputError(f"{kind} is of r and c together; leave out axis and order")
        return FAMILY_KINDS[kind].draw(comparison)
    _check_kind(kind, KINDS, "of orders")
    return KINDS[kind].draw(comparison, axis, order)


def _check_kind(kind: str, kinds: Collection[str], what: str) -> None:
    """Refuse a kind that a comparison does not have."""
    if kind not in kinds:
        raise InputError(f"{kind!r} is no kind of figure {what}; kinds: {', '.join(kinds)}")
