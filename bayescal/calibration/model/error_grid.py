"""The grid of error models, followed from its likely nodes until their neighbours are not."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.special import logsumexp

from bayescal.calibration.model.error_model import LARGEST_TARGET, ErrorModel, Geometry

Node: TypeAlias = tuple[int, int, int, int]

CORRELATED = (0.0, *(2.0**k for k in range(-3, 8)))
LENGTHS = tuple(2.0**k for k in range(-1, 6))  # spacings of the target's points
OFFSETS = (0.0, *(2.0**k for k in range(-4, 4)))
INDEPENDENT: Node = (0, 0, 0, 0)
MIDDLE = 3  # level of each part at the second node that is looked at
KEPT = 5.0  # nat below the best at which a node's neighbours are not looked at any more
ALIKE = 1.0  # nat: error models that two lenses tell apart alike are not followed anew
TOGETHER = 8  # nodes whose neighbours are evaluated at once
FEWEST_VIEWS = 3  # offsets common to fewer views can't be told from the poses


@dataclass(frozen=True)
class ErrorGrid:
    """Levels that an error model may have; which of its parts are offered.

    Each part (correlated noise, rough offsets, smooth offsets) is there with probability 1/2,
    and then at any of its levels alike.

    Attributes
    ----------
    spacing : float
        Between neighbours on the target, diagonals.
    correlated, offsets : bool
        Whether noise may be correlated, and points of the target be off.
    """

    spacing: float
    correlated: bool = True
    offsets: bool = True

    @classmethod
    def of(cls, geometry: Geometry) -> ErrorGrid:
        """Grid for a target: offsets only of few points in several views."""
        data = geometry.data
        few = len(data.target) <= LARGEST_TARGET and data.n_views >= FEWEST_VIEWS
        return cls(geometry.spacing, True, few)

    @property
    def size(self) -> Node:
        """Number of levels of each kind."""
        offsets = len(OFFSETS) if self.offsets else 1
        correlated = len(CORRELATED) if self.correlated else 1
        return (correlated, len(LENGTHS), offsets, offsets)

    @property
    def starts(self) -> tuple[Node, ...]:
        """Nodes to begin from: independent noise, and a little of all that is offered."""
        correlated, offset = (
            MIDDLE if offered else 0 for offered in (self.correlated, self.offsets)
        )
        return tuple(dict.fromkeys((INDEPENDENT, (correlated, correlated, offset, offset))))

    def error(self, node: Node) -> ErrorModel:
        """Error model at a node."""
        c, length, rough, smooth = node
        return ErrorModel(
            CORRELATED[c],
            LENGTHS[length] * self.spacing if c else 0.0,
            OFFSETS[rough],
            OFFSETS[smooth],
        )

    def log_prior(self, node: Node) -> float:
        """Log probability of a node."""
        n_correlated, n_lengths, n_offsets, _ = self.size
        total = 0.0
        for level, count in (
            (node[0], (n_correlated - 1) * n_lengths),
            *((level, n_offsets - 1) for level in node[2:]),
        ):
            if count > 0:
                total -= math.log(2) + (math.log(count) if level else 0.0)
        return total

    def neighbours(self, node: Node) -> Iterable[Node]:
        """Nodes one level away; noise without correlation has no length and touches all."""
        c, length, rough, smooth = node
        n_correlated, n_lengths, n_offsets, _ = self.size
        if c == 0 and n_correlated > 1:
            yield from ((1, other, rough, smooth) for other in range(0, n_lengths, 2))
        if c:
            yield (c - 1, length, rough, smooth) if c > 1 else (0, 0, rough, smooth)
            if c + 1 < n_correlated:
                yield (c + 1, length, rough, smooth)
            yield from (
                (c, other, rough, smooth)
                for other in (length - 1, length + 1)
                if 0 <= other < n_lengths
            )
        for step in (-1, 1):
            if 0 <= rough + step < n_offsets:
                yield (c, length, rough + step, smooth)
            if 0 <= smooth + step < n_offsets:
                yield (c, length, rough, smooth + step)

    def at_edge(self, node: Node) -> tuple[str, ...]:
        """Which levels of a node are the largest offered."""
        names = ("correlation", "length", "rough offsets", "smooth offsets")
        named = zip(names, node, self.size, strict=True)
        c = node[0]
        return tuple(
            name
            for name, level, count in named
            if count > 1 and level == count - 1 and (name != "length" or c)
        )


@dataclass(frozen=True)
class Averaged:
    """Evidence of a lens model over the error models.

    Attributes
    ----------
    log_evidence : float
        Averaged over the grid.
    nodes : tuple of Node
        Those that matter, the most probable first.
    weights : tuple of float
        Their posterior probabilities.
    tried : int
        Nodes evaluated.
    """

    log_evidence: float
    nodes: tuple[Node, ...]
    weights: tuple[float, ...]
    tried: int


def follow(
    grid: ErrorGrid,
    log_evidences: Callable[[Sequence[Node]], Sequence[float]],
    start: Iterable[Node],
    kept: float = KEPT,
    most: int = 1000,
) -> Averaged:
    """Evaluate nodes outwards from the best until their neighbours don't matter.

    Parameters
    ----------
    log_evidences : callable
        Of nodes: those next to all that are near the best are asked for together.
    kept : float, optional
        How far below the best a node may be for its neighbours to be looked at, nat.
    most : int, optional
        Nodes to evaluate at most.
    """
    found: dict[Node, float] = {}

    def evaluate(nodes: Iterable[Node]) -> None:
        new = [node for node in dict.fromkeys(nodes) if node not in found]
        for node, value in zip(new, log_evidences(new), strict=True):
            found[node] = value + grid.log_prior(node)

    evaluate(start)
    done: set[Node] = set()
    while len(found) < most:
        best = max(found, key=lambda node: found[node])
        near = [n for n, v in found.items() if n not in done and v > found[best] - kept]
        if not near:
            break
        # The best alone where it is new: others may be far from a higher one.
        near.sort(key=lambda node: -found[node])
        near = near[: 1 if near[0] == best else TOGETHER]
        done.update(near)
        evaluate(other for node in near for other in grid.neighbours(node))
    order = sorted(found, key=lambda n: -found[n])
    total = float(logsumexp(list(found.values())))
    likely = [n for n in order if found[n] > found[order[0]] - kept]
    return Averaged(
        total, tuple(likely), tuple(math.exp(found[n] - total) for n in likely), len(found)
    )


def carried_over(
    grid: ErrorGrid, log_evidences: Callable[[Sequence[Node]], Sequence[float]], like: Averaged
) -> Averaged | None:
    """Average over the nodes that mattered to another lens, where they matter alike to this one.

    The nodes beside them are taken to have the share that they had there.

    Parameters
    ----------
    log_evidences : callable
        As of `follow`.

    Returns
    -------
    Averaged or None
        None where the lenses tell nodes apart differently, or the best one is beside them.
    """
    shares = dict(zip(like.nodes, np.log(like.weights).tolist(), strict=True))
    found: dict[Node, float] = {}
    # Those that are followed in any case first.
    for some in ((like.nodes[0], *grid.neighbours(like.nodes[0])), like.nodes):
        new = [node for node in dict.fromkeys(some) if node not in found]
        for node, value in zip(new, log_evidences(new), strict=True):
            found[node] = value + grid.log_prior(node)
        best = max(found.values())
        if any(v > best - KEPT + ALIKE for n, v in found.items() if n not in shares):
            return None
        if np.ptp([v - shares[n] for n, v in found.items() if n in shares]) > ALIKE:
            return None
    order = sorted(like.nodes, key=lambda node: -found[node])
    total = float(logsumexp([found[n] for n in order])) - math.log(math.fsum(like.weights))
    weights = tuple(math.exp(found[node] - total) for node in order)
    return Averaged(total, tuple(order), weights, len(found))
