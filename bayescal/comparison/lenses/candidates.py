"""Which lens models are compared: plain first, going on while the evidence rises."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.calibration.model.lens_model import LensModel
from bayescal.cameras.lenses import LENSES, Lens, lens_named
from bayescal.comparison.key import Key
from bayescal.errors import InputError

LARGEST_RADIAL, LARGEST_FISHEYE = 5, 5
SURE_RADIAL, SURE_FISHEYE = 2, 2  # orders that are looked at in any case


@dataclass(frozen=True)
class LensKey(Key):
    """Which lens, over many views: of one family to a comparison, so that all are alike before."""

    family: str = "lens"
    orders: tuple[int, ...] = ()
    name: str = ""

    def file(self, usual: str = "") -> str:  # noqa: ARG002 - there is one noise model
        """Name of its draws in a run."""
        return self.name.replace(" + ", "-").replace(" ", "-")

    def rng(self, seed: int, *further: int) -> np.random.Generator:
        """Random numbers of its own."""
        place = *self.name.encode(), *further
        return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=place))

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, eq=False)
class Candidate:
    """A lens model to be judged.

    Attributes
    ----------
    name : str
        As tables show it.
    order : int or None
        Number of radial coefficients, where the family has orders.
    lens_name : str
        As `bayescal.cameras.lenses.lens_named` takes it.
    options : dict
        What else it takes.
    parents : tuple of str
        Names of candidates it contains: its fit may begin from theirs.
    """

    name: str
    family: str
    order: int | None
    lens: Lens
    lens_name: str
    options: dict[str, int | bool]
    parents: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        name: str,
        lens: str,
        order: int | None = None,
        options: dict[str, int | bool] | None = None,
        *,
        family: str = "",
        parents: tuple[str, ...] = (),
    ) -> Candidate:
        """Make the lens; `family` is its own name by default.

        Raises
        ------
        InputError
            Where it has no such option or order.
        """
        given = options or {}
        made = lens_named(lens, **given)
        return cls(name, family or lens, order, made, lens, given, parents)

    def model(
        self, size: tuple[float, float], *, square: bool = False, centred: bool = False
    ) -> LensModel:
        """Parameters of the lens for an image of a size, px."""
        return LensModel(self.name, self.lens, size, square, centred)


def radial_candidates(order: int) -> list[Candidate]:
    """Radial lens of an order, without and with tangential terms."""
    if order == 0:
        return [radial_candidate(0)]
    return [radial_candidate(order), radial_candidate(order, tangential=True)]


def radial_candidate(order: int, *, tangential: bool = False) -> Candidate:
    """Radial lens of an order."""
    name = "pinhole" if order == 0 else f"radial {order}"
    below = "pinhole" if order == 1 else f"radial {order - 1}"
    parents: tuple[str, ...] = (below,) if order else ()
    if tangential:
        parents = (name, f"{below} + p")[: min(order, 2)]
        name = f"radial {order} + p"
    options = {"order": order, "tangential": tangential}
    return Candidate.of(name, "radial", order, options, parents=parents)


def fisheye_candidate(order: int) -> Candidate:
    """Fisheye lens of an order."""
    parents = (f"fisheye {order - 1}",) if order else ()
    return Candidate.of(f"fisheye {order}", "fisheye", order, {"order": order}, parents=parents)


def other_candidates() -> list[Candidate]:
    """Lens models without an order, or that are compared at one."""
    return [Candidate.of(name, name) for name in ("division", "eucm", "double-sphere")]


def rational_candidate() -> Candidate:
    """OpenCV's eight coefficients, over the polynomial of three and tangential terms."""
    return Candidate.of("opencv8", "opencv8", 3, family="rational", parents=("radial 3 + p",))


def named_candidates(names: Sequence[str]) -> list[Candidate]:
    """Candidates as the user names them: ``radial 2``, ``fisheye 3``, ``opencv5``, ``eucm``.

    Raises
    ------
    InputError
        Where a name is not known, or has no such order.
    """
    found: dict[str, Candidate] = {}
    for text in names:
        candidate = named_candidate(text)
        found.setdefault(candidate.name, candidate)
    if not found:
        raise InputError("lens: none is named; leave it out to have them found")
    return list(found.values())


def named_candidate(text: str) -> Candidate:
    """Candidate of one name; errors as of `named_candidates`."""
    words = text.replace(":", " ").replace("+", " + ").split()
    name, rest = (words[0], words[1:]) if words else ("", [])
    if name == "pinhole" and not rest:
        return radial_candidate(0)
    if name not in LENSES:
        raise InputError(f"lens {text!r}: use pinhole, {', '.join(LENSES)}, with an order")
    tangential = "".join(rest[-2:]) == "+p"
    orders = rest[:-2] if tangential else rest
    if (
        len(orders) > 1
        or (orders and not orders[0].isdecimal())
        or (tangential and name != "radial")
    ):
        raise InputError(
            f"lens {text!r}: give a name and an order, such as 'radial 2' or 'radial 2 + p'"
        )
    if text == rational_candidate().name:
        return rational_candidate()
    if not orders:
        return Candidate.of(name, name)
    order = int(orders[0])
    if name == "radial":
        return radial_candidate(order, tangential=tangential)
    if name == "fisheye":
        return fisheye_candidate(order)
    return Candidate.of(f"{name} {order}", name, order, {"order": order})
