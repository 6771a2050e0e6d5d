r"""Maps over the image: where a calibration can be believed, and what another model would change.

Each place of a grid looks at a point of the world by the chosen model; maps show how that point's
prediction spreads, and where other plausible models predict it. A difference is that of the
posterior means. Its deviation is of what the model with more parameters adds: the other is fitted
to each of its draws over the calibrated part, linearly, and what is left spreads by so much. (The
deviation of each alone would count the noise that both share.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import BoolArray, Member
from bayescal.prediction.predict import predict
from bayescal.prediction.sights import COLUMNS, ROWS, Sights, extent, image_grid, sights
from bayescal.rounding import rounded, significant

NAMES = (
    *("centre", "left edge", "right edge", "top edge", "bottom edge"),
    *("top left corner", "top right corner", "bottom left corner", "bottom right corner"),
)
CORNERS = 5  # the first corner among them
FITTED = (13, 9)  # grid at which one model is fitted to another's draws


@dataclass(frozen=True, eq=False)
class ModelDifference:
    """What another plausible model predicts for the same points.

    Attributes
    ----------
    chosen, other : str
        Names of the models.
    probability : float
        Of the other, among all that are kept.
    shift : Array
        Its prediction less the chosen model's, ``(n, 2)``, px as recorded.
    sd : Array
        Of the shift along its own direction, ``(n,)``, px.
    """

    chosen: str
    other: str
    probability: float
    shift: Array
    sd: Array

    @property
    def size(self) -> Array:
        """Length of the shift, ``(n,)``, px."""
        return np.asarray(np.hypot(*self.shift.T))

    def bound(self, i: int) -> str | None:
        """How far a place can be moved at most (95%), px; None where the shift is known better.

        A shift below its deviation is not known: only that it and two deviations are not exceeded.
        """
        size, sd = float(self.size[i]), float(self.sd[i])
        return significant(size + 2 * sd) if sd > size else None

    def told(self, i: int) -> str:
        """How far a place is moved, px: with its deviation or a bound; empty where unseen."""
        size, sd, bound = float(self.size[i]), float(self.sd[i]), self.bound(i)
        if not np.isfinite(size):
            return ""
        return f"<{bound}" if bound else f"{rounded(size, sd)} ± {significant(sd)}"


@dataclass(frozen=True, eq=False)
class ImageMaps:
    """Maps over the image; n places, row by row; nan where the chosen model sees nothing.

    Attributes
    ----------
    shape : tuple of int
        Rows and columns of the grid.
    places : Sights
    epistemic : Array
        Sd of the chosen model's mapping, root mean square of r and c, ``(n,)``, px.
    predictive : Array
        Sd of a new measurement by it, ``(n,)``, px.
    averaged : Array
        Sd of the mapping averaged over the plausible models, ``(n,)``, px.
    differences : tuple of ModelDifference
        Of every other plausible model, the most probable first.
    hull : Array
        Corners of the hull of the calibration points, ``(m, 2)``, px.
    chosen : str
    named : ImageMaps or None
        The same at the places of the image that have `NAMES`; None where these are they.
    """

    shape: tuple[int, int]
    places: Sights
    epistemic: Array
    predictive: Array
    averaged: Array
    differences: tuple[ModelDifference, ...]
    hull: Array
    chosen: str
    named: ImageMaps | None

    def __repr__(self) -> str:
        rows, columns = self.shape
        told = f"{rows} rows of {columns}" if self.named is not None else "named places"
        return f"<ImageMaps: {told}, by {self.chosen}, {len(self.differences)} other models>"

    @property
    def extrapolated(self) -> BoolArray:
        """Which places the model reaches only by going beyond its points, ``(n,)``."""
        return self.places.found & ~self.places.inside

    @property
    def sentences(self) -> tuple[str, ...]:
        """What each other plausible model would move, in words."""
        assert self.named is not None, "of the whole image"
        pairs = zip(self.differences, self.named.differences, strict=True)
        return tuple(self._sentence(over, at, self.named.places) for over, at in pairs)

    def _sentence(self, over: ModelDifference, at: ModelDifference, places: Sights) -> str:
        inner = over.size[self.places.inside]
        inside = ""
        if np.isfinite(inner).any():
            most = significant(float(np.nanmax(inner)))
            inside = f"no place among the calibration points by more than {most} px"
        moved = f"Going from {over.chosen} to {over.other} moves"
        size = at.size[CORNERS:]
        if not np.isfinite(size).any():
            return f"{moved} {inside or 'nothing that both models see'}."
        worst = CORNERS + int(np.nanargmax(size))
        beyond = "" if places.inside[worst] else ", extrapolated"
        known, bound = at.told(worst), at.bound(worst)
        by = f"{known} px" if bound is None else f"up to {bound} px (95%)"
        return (
            f"{moved} the worst corner ({NAMES[worst].removesuffix(' corner')}{beyond}) by "
            f"{by}{', and ' if inside else ''}{inside}."
        )


def image_maps(camera: CalibratedCamera, *, columns: int = COLUMNS, rows: int = ROWS) -> ImageMaps:
    """Make the maps of a camera; parameters as of `bayescal.image_maps`."""
    named = _maps(camera, named_pixels(camera), (len(NAMES), 1), None)
    return _maps(camera, image_grid(camera, columns, rows), (rows, columns), named)


def _maps(
    camera: CalibratedCamera, pixels: Array, shape: tuple[int, int], named: ImageMaps | None
) -> ImageMaps:
    places = sights(camera, pixels)
    one, all_of_them = (
        predict(camera, np.nan_to_num(places.world), average=average) for average in (False, True)
    )

    def over(sd: Array) -> Array:
        return np.where(places.found, np.sqrt((sd**2).mean(axis=1)), np.nan)

    return ImageMaps(
        shape,
        places,
        over(one.sd),
        over(one.new_sd),
        over(all_of_them.sd),
        differences(camera, places),
        camera.pixel_hull,
        camera.chosen.name,
        named,
    )


def named_pixels(camera: CalibratedCamera) -> Array:
    """Pixels of the `NAMES` as recorded, ``(9, 2)``, px."""
    (left, top), (right, bottom) = extent(camera)  # recorded rows are counted from the top
    r, c = (left + right) / 2, (top + bottom) / 2
    edges = [[r, c], [left, c], [right, c], [r, top], [r, bottom]]
    return np.array([*edges, [left, top], [right, top], [left, bottom], [right, bottom]])


def differences(camera: CalibratedCamera, at: Sights) -> tuple[ModelDifference, ...]:
    """Compare every other model with the chosen one at places of the image."""
    fitted = sights(camera, image_grid(camera, *FITTED))
    fit_at = fitted.world[fitted.inside]
    chosen = camera.chosen
    sign = np.array([1.0, -1.0 if camera.c_from_bottom else 1.0])
    out = []
    for member, p in zip(camera.members[1:], camera.probabilities[1:], strict=True):
        shift = np.full((len(at.pixels), 2), np.nan)
        sd = np.full(len(at.pixels), np.nan)
        world = at.world[at.found]
        means = [_mean(m, world) for m in (chosen, member)]
        shift[at.found] = (means[1] - means[0]) * sign
        pair = sorted((chosen, member), key=lambda m: len(m.parameters.mean))
        sd[at.found] = _added(pair[0], pair[1], fit_at, world, means[1] - means[0])
        out.append(ModelDifference(chosen.name, member.name, p, shift, sd))
    return tuple(out)


def _mean(member: Member, world: Array) -> Array:
    """Pixels of a model's mean, ``(n, 2)``; nan where it sees nothing."""
    pixels, seen = member.project(member.parameters.mean[None], world)
    return np.where(seen[0, :, None], pixels[0], np.nan)


def _added(smaller: Member, larger: Member, fit_at: Array, world: Array, shift: Array) -> Array:
    """Sd along the shift of what the larger model's draws add to the smaller, ``(n,)``."""
    here, there = (_slopes(smaller, points) for points in (fit_at, world))
    drawn = [larger.project(larger.parameters.draws, points)[0] for points in (fit_at, world)]
    spread, moved = (d - d.mean(axis=0) for d in drawn)
    m = len(moved)
    absorbed = np.linalg.pinv(here, rcond=1e-10) @ spread.reshape(m, -1).T
    left = moved - (there @ absorbed).T.reshape(moved.shape)
    length = np.hypot(*shift.T)
    along = shift / np.where(length > 0, length, 1.0)[:, None]
    return np.asarray(np.einsum("mna,na->mn", left, along).std(axis=0))


def _slopes(member: Member, world: Array) -> Array:
    """How pixels follow one-sd steps of a model's parameters, ``(2 n, d)``."""
    steps = member.parameters.steps
    pixels, _ = member.project(steps, world)
    d = (len(steps) - 1) // 2
    return np.asarray((pixels[1 : 1 + d] - pixels[1 + d :]).reshape(d, -1).T / 2)
