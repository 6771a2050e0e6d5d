"""The kinds of figure: what each shows, what it needs, how it is drawn and described."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

from bayescal.errors import InputError

if TYPE_CHECKING:  # the command's help lists the kinds without paying for matplotlib
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from bayescal.comparison.families.results import FamilyComparison
    from bayescal.comparison.lenses.results import LensComparison
    from bayescal.comparison.outliers.results import OutlierStudy
    from bayescal.comparison.results import Comparison
    from bayescal.prediction.calibrated.camera import CalibratedCamera

CAMERA = "camera"  # what several kinds of result hold
HOLD_CAMERA = ("comparison", "families", "lenses", CAMERA)


class FigureModule(Protocol):
    """What the module of a kind offers.

    Both raise `InputError`, with the reason in words, where there is nothing to draw.
    """

    def draw(self, subject: Any, /) -> Figure:
        """Draw the figure."""
        ...

    def alt_text(self, subject: Any, /) -> str:
        """Say in a sentence or two what is to be seen, with its numbers."""
        ...


@dataclass(frozen=True)
class FigureKind:
    """One kind of figure.

    Attributes
    ----------
    name : str
        As the command line takes it, unique among those of `of`; also its module in that folder.
    summary : str
        One line.
    one_axis : bool
        Whether it is of one axis, which must be named where there are two; else of all
        axes, or of the one named.
    one_order : bool
        Whether it is of one order; else it shows every order compared.
    of_defence : bool
        Whether it shows what a defended comparison holds, and else computes that alone.
    of : str
        The kind of result it is drawn of (`bayescal.report.runs`).
    """

    name: str
    summary: str
    one_axis: bool = False
    one_order: bool = False
    of_defence: bool = False
    of: str = "comparison"

    def draw(
        self,
        result: Any,
        axis: str | None = None,
        order: int | None = None,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw it.

        Parameters
        ----------
        axis : str, optional
            Of `result.axes`; may be left out where there is only one, and for a
            figure of all axes.
        order : int, optional
            One of those compared; the chosen one by default.
        ax : Axes, optional
            Where to draw a figure of one panel.

        Raises
        ------
        InputError
            Where axis or order are missing, foreign or not taken, there is nothing
            to draw, or too much for `ax`; says why.
        """
        subject = self._subject(result, axis, order)
        from bayescal.report.figures.style import styled

        with styled(ax):
            return self._module.draw(subject)

    def alt_text(self, result: Any, axis: str | None = None, order: int | None = None) -> str:
        """Describe it for those who can't see it; parameters and errors as `draw`."""
        return self._module.alt_text(self._subject(result, axis, order))

    @property
    def _module(self) -> FigureModule:
        name = self.name.replace("-", "_")
        return cast("FigureModule", import_module(f"bayescal.report.figures.{self.of}.{name}"))

    def _subject(self, result: Any, axis: str | None, order: int | None) -> Any:
        """Give what its module draws: an axis and order of a comparison, or the whole result."""
        if order is not None and not self.one_order:
            raise InputError(f"{self.name} shows every order; leave out the order")
        return SUBJECTS[self.of](self, result, axis, order)


def _whole(kind: FigureKind, result: Any, axis: str | None, _: int | None = None) -> Any:
    """Take a result that is joint, of r and c."""
    if axis is not None:
        raise InputError(f"{kind.name} is joint, of r and c; leave out the axis")
    return result


def _maps(kind: FigureKind, result: Any, axis: str | None, _: int | None) -> Any:
    return maps_of(_whole(kind, result, axis))


def _axis_of(
    kind: FigureKind, result: Any, axis: str | None, order: int | None = None
) -> str | None:
    """Name the axis; None where a figure is of all."""
    names = ", ".join(result.axes)
    if axis is not None and axis not in result.axes:
        raise InputError(f"axis {axis} was not compared; axes: {names}")
    if axis is None and len(result.axes) == 1:
        (axis,) = result.axes
    if axis is None and (kind.one_axis or order is not None):
        raise InputError(f"{kind.name} needs an axis, one of {names}")
    return axis


def _bad_points(kind: FigureKind, result: Any, axis: str | None, _: int | None) -> Any:
    return result.axes[_axis_of(kind, result, axis)]


def _orders(kind: FigureKind, result: Any, axis: str | None, order: int | None) -> Any:
    """Take an axis and an order of a comparison."""
    from bayescal.report.figures.subject import Subject

    subject = Subject(result, _axis_of(kind, result, axis, order), order)
    if order is not None:
        subject.check_order()
    return subject


# What a module draws, by what its kind is of.
SUBJECTS: dict[str, Callable[[FigureKind, Any, str | None, int | None], Any]] = {
    "comparison": _orders,
    "families": _whole,
    "lenses": _whole,
    "outliers": _bad_points,
    CAMERA: _maps,
}


def maps_of(result: Any) -> Any:
    """Make the maps of a camera, or of a result that holds one; maps stay as they are."""
    from bayescal.prediction.calibrated.camera import CalibratedCamera
    from bayescal.prediction.changed import Change
    from bayescal.prediction.maps import ImageMaps, image_maps
    from bayescal.report.camera import camera_of

    if isinstance(result, ImageMaps | Change):
        return result
    return image_maps(result if isinstance(result, CalibratedCamera) else camera_of(result))


# A kind is one module in the folder of its result and one line here.
FIGURES = (
    FigureKind("verdict", "probability of each order, all axes"),
    FigureKind("joint", "probability of each pair of orders"),
    FigureKind("evidence", "log evidence of each order over fixed tau", one_axis=True),
    FigureKind("loo", "leave-one-out differences, with errors", one_axis=True, of_defence=True),
    FigureKind("bootstrap", "share of resamples each order wins", one_axis=True, of_defence=True),
    FigureKind("residuals", "residuals over the regressor", one_axis=True, one_order=True),
    FigureKind("other", "residuals over the other axis's regressor", one_axis=True, one_order=True),
    FigureKind("image", "residuals over the image plane, as arrows", one_order=True),
    FigureKind("qq", "normal quantiles of the residuals", one_axis=True, one_order=True),
    FigureKind(
        "curve", "fitted curve and data less the straight part", one_axis=True, one_order=True
    ),
    FigureKind(
        "corner",
        "posterior of all parameters, draws and closed form",
        one_axis=True,
        one_order=True,
    ),
    FigureKind("trace", "chains and their ranks", one_axis=True, one_order=True),
    FigureKind("autocorrelation", "autocorrelation of the chains", one_axis=True, one_order=True),
    FigureKind("models", "log evidence of every model of r and c", of="families"),
    FigureKind("vectors", "residuals of the best models over the image", of="families"),
    FigureKind("position", "camera position against the stated one", of="families"),
    FigureKind("correlation", "correlations of the parameters", of="families"),
    FigureKind("sd-map", "how sure the mapping is, over the image", of=CAMERA),
    FigureKind("difference-map", "what other plausible models change over the image", of=CAMERA),
    FigureKind("bad-points", "residual and probability of being bad", one_axis=True, of="outliers"),
    FigureKind("evidence", "log evidence over the order", of="lenses"),
    FigureKind("models", "log evidence of every lens", of="lenses"),
    FigureKind("corner", "posterior of the lens", of="lenses"),
    FigureKind("vectors", "residuals of all views over the image", of="lenses"),
    FigureKind("views", "residuals view by view", of="lenses"),
    FigureKind("bow", "the target's bow, and its points that are off", of="lenses"),
)

# Of two cameras: no run holds it.
CHANGE = "change"
CHANGE_MAP = FigureKind("change-map", "how far two calibrations lie apart", of=CAMERA)


def figure_kinds(of: str) -> dict[str, FigureKind]:
    """Give the kinds of figure of a kind of result, by their names."""
    if of == CHANGE:
        return {CHANGE_MAP.name: CHANGE_MAP}
    held = (of, CAMERA) if of in HOLD_CAMERA else (of,)
    return {kind.name: kind for kind in FIGURES if kind.of in held}


def drawn_as(result: object) -> str:
    """Name the kind of result that something is drawn as."""
    from bayescal.prediction.calibrated.camera import CalibratedCamera
    from bayescal.prediction.changed import Change
    from bayescal.prediction.maps import ImageMaps
    from bayescal.report.runs import kind_of

    if isinstance(result, Change):
        return CHANGE
    return CAMERA if isinstance(result, CalibratedCamera | ImageMaps) else kind_of(result).name


# What figures of lenses were called in version 0.1.0.
ALIASES = {"uncertainty": "sd-map", "difference": "difference-map"}
# By their names alone: where several kinds of result have one, that of the first.
KINDS = {kind.name: next(k for k in FIGURES if k.name == kind.name) for kind in FIGURES}


def plot(
    comparison: Comparison | FamilyComparison | OutlierStudy | LensComparison | CalibratedCamera,
    kind: str,
    *,
    axis: str | None = None,
    order: int | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Draw one kind of figure of a comparison.

    Parameters
    ----------
    comparison : Comparison, FamilyComparison, OutlierStudy, LensComparison or CalibratedCamera
        From `compare`, `compare_polynomials`, `fit`, `compare_families`, `fit_family`,
        `outliers`, `calibrate`, `open_run` or `camera`.
    kind : str
        Of orders: ``"verdict"``, ``"joint"``, ``"evidence"``, ``"loo"``, ``"bootstrap"``,
        ``"residuals"``, ``"other"``, ``"image"``, ``"qq"``, ``"curve"``, ``"corner"``,
        ``"trace"``, ``"autocorrelation"``. Of families: ``"models"``, ``"vectors"``,
        ``"position"``, ``"correlation"``. Of bad points: ``"bad-points"``. Of lenses:
        ``"evidence"``, ``"models"``, ``"corner"``, ``"vectors"``, ``"views"``, ``"bow"``.
        Of a camera, or of orders, families or lenses: ``"sd-map"``, ``"difference-map"``.
        Of what `changed` gives: ``"change-map"``.
    axis : str, optional
        ``"r"``, ``"c"`` or ``"y"``; may be left out where there is only one, and for
        a figure of all axes. Families and lenses have none.
    order : int, optional
        One of those compared; the recommended one by default. Families and lenses have none.
    ax : matplotlib.axes.Axes, optional
        Where to draw, of any figure: in your own style, and what has several panels not at all.

    Returns
    -------
    matplotlib.figure.Figure
        That of `ax`; else one not known to pyplot: save it with its ``savefig``.

    Raises
    ------
    InputError
        Where there is no such kind, axis or order, nothing to draw, or too much for `ax`; says
        why.
    """
    of = drawn_as(comparison)
    known, kind = figure_kinds(of), ALIASES.get(kind, kind)
    if kind not in known:
        raise InputError(f"{kind!r} is no kind of figure of {of}; kinds: {', '.join(known)}")
    return known[kind].draw(comparison, axis, order, ax)
