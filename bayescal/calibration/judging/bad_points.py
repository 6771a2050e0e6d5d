r"""Points that are bad: anywhere in the image, and not where the lens puts them.

Each point is bad with probability eps, independently, and then anywhere in an image of area A
(Hogg, Bovy & Lang 2010, arXiv:1008.4686, section 3). With z the set of bad points, k of N,

    p(data | lens) = sum_z p(z) A^-k p(points not in z | lens),

and eps uniform on 0 to 1 makes p(z) = B(1 + k, 1 + N - k). About one set, a point i is bad rather
than good by the factor A^-1 / p(i | all good points). Few points are in doubt; as long as these
factors do not depend on each other's state, the sum over the sets of points in doubt is

    sum_k B(1 + c + k, 1 + N - c - k) e_k,

c the points that are bad beyond doubt, e_k the elementary symmetric polynomials of the factors.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaln, expit, logsumexp

from bayescal.arrays import Array, IntArray
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.free_points import FreePoints
from bayescal.calibration.judging.laplace import degrees

DOUBT = 12.0  # nat: points with larger odds either way are not in doubt
TURNS = 6  # of dropping and adding points
FEWEST = 4  # good points of a view, and half of its points: fewer do not place it


@dataclass(frozen=True, eq=False)
class BadPoints:
    """A set of bad points with the sets about it.

    Attributes
    ----------
    places : tuple of int
        The set: number of each in ``(n_views, n_places)``, row by row.
    shift : Array
        Observed less where the good points put it, px, ``(n_views, n_places, 2)``; NaN of points
        that the others can't do without.
    chance : Array
        Probability of being bad, ``(n_views, n_places)``; 0 where nothing was seen.
    fraction : float
        Posterior mean of the fraction of bad points, eps.
    log_share : float
        Log of the evidence of all these sets over that of the points that are not in the set, nat.
    """

    places: tuple[int, ...]
    shift: Array
    chance: Array
    fraction: float
    log_share: float

    @property
    def points(self) -> NDArray[np.bool_]:
        """The set, ``(n_views, n_places)``."""
        return marked(self.places, self.chance.shape)

    @property
    def likely(self) -> NDArray[np.bool_]:
        """Points that are rather bad than good, ``(n_views, n_places)``."""
        return np.asarray(self.chance > 0.5)

    @property
    def doubtful(self) -> NDArray[np.bool_]:
        """Points over whose being bad or good is summed, ``(n_views, n_places)``."""
        least = math.exp(-DOUBT)
        return np.asarray((self.chance > least) & (self.chance < 1 - least))


def marked(places: Iterable[int], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Mark places, counted row by row."""
    out = np.zeros(shape, dtype=bool)
    out.flat[list(places)] = True
    return out


def search(problem: Problem, start: NDArray[np.bool_], ahead: int) -> NDArray[np.bool_]:
    """Find the most probable set of bad points near a set, under a settled problem.

    Points are added by falling odds, each beside those before it, and as many are kept as make
    the set most probable: gross errors that hide each other have odds below 1 one by one.

    Parameters
    ----------
    problem : Problem
        Of all points; linearised where those not in `start` put it.
    ahead : int
        How many points are added beyond the best set so far.
    """
    chosen = start
    if not problem.stack.possible:
        return chosen
    for _ in range(TURNS):
        free = _released(problem, np.argwhere(chosen))
        odds = _odds(free, chosen)
        doubtful = chosen & (np.nan_to_num(odds) < 0)
        if doubtful.any():
            chosen = chosen & ~doubtful
            free = _released(problem, np.argwhere(chosen))
        added = _added(free, ahead)
        chosen = chosen.copy()
        for at in added:
            chosen[at] = True
        if not added:
            break
    return chosen


def about(problem: Problem, points: NDArray[np.bool_]) -> BadPoints:
    """Sum over the sets about one, under a problem settled to the points not in it."""
    data = problem.data
    n, k = data.n_points, int(points.sum())
    places = tuple(np.flatnonzero(points).tolist())
    if not problem.stack.possible or degrees(data) - problem.model.dimension - 2 * k <= 2:
        nothing, alone = (
            np.full((*points.shape, 2), np.nan),
            log_prior(n, k) - k * log_area(data.size),
        )
        return BadPoints(places, nothing, points.astype(float), (1 + k) / (n + 2), float(alone))
    free = _released(problem, np.argwhere(points))
    log_ratio = _log_ratio(free, points)
    shift = np.full((*points.shape, 2), np.nan)
    shift[points] = free.released()[0]
    left = free.left
    moved = np.linalg.solve(free.metric[left], free.weighted[left][..., None])[..., 0]
    shift[left] = moved / data.weight[left]
    odds = log_ratio + _log_prior_odds(n, k - points)
    known = np.isfinite(odds)
    towards = np.where(points, odds, -odds)
    doubt = known & (towards < DOUBT)
    certain = points & ~doubt
    total, chance, count = _summed(log_ratio[doubt], int(certain.sum()), n)
    chances = np.where(known, expit(np.where(known, odds, 0.0)), points.astype(float))
    chances[doubt] = chance
    log_share = total - log_ratio[doubt & points].sum() - k * log_area(data.size)
    return BadPoints(places, shift, chances, (1 + count) / (n + 2), float(log_share))


def fewest_good(count: int) -> int:
    """How many of a view's points must be good."""
    return max(FEWEST, (count + 1) // 2)


def log_area(size: tuple[float, float]) -> float:
    """Log of the image's area, px^2."""
    return math.log(size[0]) + math.log(size[1])


def log_prior(n: int, k: Array | IntArray | int) -> Array:
    """Log probability of a set of k of n points, their fraction uniform on 0 to 1."""
    return np.asarray(betaln(1 + np.asarray(k), 1 + n - np.asarray(k)))


def _log_prior_odds(n: int, k: Array | IntArray) -> Array:
    """Log of the odds of one point more being bad where k others of n are."""
    return np.log1p(k) - np.log(n - k)


def _released(problem: Problem, points: IntArray) -> FreePoints:
    """Give points shifts of their own."""
    free = FreePoints(problem)
    for view, place in points.tolist():
        free.release(view, place)
    return free


def _log_ratio(free: FreePoints, points: NDArray[np.bool_]) -> Array:
    """Log of how much likelier each point is as a bad one; NaN where that can't be told."""
    out = free.log_density()
    out[_spare(free) <= 0] = np.nan
    out[points] = free.released()[1]
    return np.asarray(-out - log_area(free.data.size))


def _odds(free: FreePoints, points: NDArray[np.bool_]) -> Array:
    n, k = free.data.n_points, int(points.sum())
    return _log_ratio(free, points) + _log_prior_odds(n, k - points)


def _spare(free: FreePoints) -> IntArray:
    """How many more points of each view may be bad, ``(n_views,)``."""
    counts = free.data.counts
    gone = np.bincount([view for view, _ in free.order], minlength=len(counts))
    return np.array([n - fewest_good(n) for n in counts.tolist()]) - gone


def _added(free: FreePoints, ahead: int) -> list[tuple[int, int]]:
    """Points that make the set more probable, the likeliest first."""
    n, area, spare = free.data.n_points, log_area(free.data.size), _spare(free)
    path: list[tuple[int, int]] = []
    total, best, kept, k = 0.0, 0.0, 0, len(free.order)
    while len(path) < kept + ahead and free.dof > 2 and not free.full:
        free.left &= (spare > 0)[:, None]
        if not free.left.any():
            break
        log_ratio = np.nan_to_num(-free.log_density() - area, nan=-np.inf)
        view, place = map(int, np.unravel_index(int(log_ratio.argmax()), log_ratio.shape))
        total += float(log_ratio[view, place] + _log_prior_odds(n, np.array(k + len(path))))
        free.release(view, place)
        spare[view] -= 1
        path.append((view, place))
        if total > best:
            best, kept = total, len(path)
    return path[:kept]


def _summed(log_ratio: Array, certain: int, n: int) -> tuple[float, Array, float]:
    """Sum over the sets of points in doubt; their chances, and how many are bad on average."""
    m = len(log_ratio)
    # Row i: the first i points in all ways, by how many of them are bad; the others' part of it.
    before, after = np.full((m + 1, m + 1), -np.inf), np.full((m + 1, m + 2), -np.inf)
    before[0, 0] = 0.0
    after[m, : m + 1] = log_prior(n, certain + np.arange(m + 1))
    for i in range(m):
        before[i + 1] = np.logaddexp(before[i], np.append(-np.inf, before[i, :-1] + log_ratio[i]))
    for i in reversed(range(m)):
        after[i] = np.logaddexp(after[i + 1], np.append(after[i + 1, 1:], -np.inf) + log_ratio[i])
    total = float(after[0, 0])
    share = logsumexp(before[:m] + after[1:, 1:], axis=1) + log_ratio - total
    chance = np.minimum(np.exp(share), 1.0)
    return total, chance, certain + float(chance.sum())
