"""The kinds of figure: what each shows, what it needs, how it is drawn and described."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

from bayescal.errors import InputError

if TYPE_CHECKING:  # the command's help lists the kinds without paying for matplotlib
    from matplotlib.figure import Figure

    from bayescal.comparison.results import Comparison
    from bayescal.report.figures.subject import Subject


class FigureModule(Protocol):
    """What the module of a kind offers.

    Both raise `InputError`, with the reason in words, where there is nothing to draw.
    """

    def draw(self, subject: Subject) -> Figure:
        """Draw the figure."""
        ...

    def alt_text(self, subject: Subject) -> str:
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
    scope : str
        What it is drawn of: ``"comparison"`` (all axes together), ``"axis"`` (every
        order of one axis) or ``"order"`` (one order of one axis).
    needs_defence : bool
        Whether it shows what only a defended comparison holds.
    """

    name: str
    summary: str
    scope: str
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
    def _module(self) -> FigureModule:
        return cast(FigureModule, import_module(f"bayescal.report.figures.{self.name}"))

    def _subject(self, comparison: Comparison, axis: str | None, order: int | None) -> Subject:
        from bayescal.report.figures.subject import Subject

        if order is not None and self.scope != "order":
            raise InputError(f"{self.name} shows every order; leave out the order")
        if axis is not None and axis not in comparison.axes:
            raise InputError(f"axis {axis} was not compared; axes: {', '.join(comparison.axes)}")
        if axis is None and self.scope != "comparison":
            if len(comparison.axes) > 1:
                raise InputError(
                    f"{self.name} is of one axis; say which: {', '.join(comparison.axes)}"
                )
            (axis,) = comparison.axes
        if self.needs_defence and any(a.defence is None for a in comparison.axes.values()):
            raise InputError(f"{self.name} needs a defended comparison (defend=True, --defend)")
        subject = Subject(comparison, axis, order)
        if order is not None:
            subject.check_order()
        return subject


KINDS: dict[str, FigureKind] = {
    kind.name: kind
    for kind in (
        FigureKind("verdict", "probability of each order, all axes", "comparison"),
        FigureKind("joint", "probability of each pair of orders", "comparison"),
        FigureKind("evidence", "log evidence of each order over fixed tau", "axis"),
        FigureKind("loo", "leave-one-out differences with their errors", "axis", True),
        FigureKind("bootstrap", "share of resamples that each order wins", "axis", True),
        FigureKind("residuals", "residuals over the regressor", "order"),
        FigureKind("other", "residuals over the other axis's regressor", "order"),
        FigureKind("image", "residuals over the image plane", "order"),
        FigureKind("qq", "normal quantiles of the residuals", "order"),
        FigureKind("curve", "fitted curve and data less the straight part", "order"),
        FigureKind("corner", "posterior of all parameters, draws and closed form", "order"),
        FigureKind("trace", "chains and their ranks", "order"),
        FigureKind("autocorrelation", "autocorrelation of the chains", "order"),
    )
}
