"""Which lens models are compared: plain first, going on while the evidence rises."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.calibration.model.lens_model import LensModel
from bayescal.cameras.lenses import LENSES, Lens, lens_named
from bayescal.cameras.lenses.radial import radial
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
    parents : tuple of str
        Names of candidates it contains: its fit may begin from theirs.
    """

    name: str
    family: str
    order: int | None
    lens: Lens
    parents: tuple[str, ...] = ()

    def model(
        self, size: tuple[float, float], *, square: bool = False, centred: bool = False
    ) -> LensModel:
        """Parameters of the lens for an image of a size, px."""
        return LensModel(self.name, self.lens, size, square, centred)


def radial_candidates(order: int) -> list[Candidate]:
    """Radial lens of an order, without and with tangential terms."""
    if order == 0:
        return [Candidate("pinhole", "radial", 0, radial(0, tangential=False))]
    below = "pinhole" if order == 1 else f"radial {order - 1}"
    plain = Candidate(f"radial {order}", "radial", order, radial(order, tangential=False), (below,))
    parents = (f"radial {order}", *((f"radial {order - 1} + p",) if order > 1 else ()))
    tangential = Candidate(
        f"radial {order} + p", "radial", order, radial(order, tangential=True), parents
    )
    return [plain, tangential]


def fisheye_candidate(order: int) -> Candidate:
    """Fisheye lens of an order."""
    parents = (f"fisheye {order - 1}",) if order else ()
    lens = lens_named("fisheye", order=order)
    return Candidate(f"fisheye {order}", "fisheye", order, lens, parents)


def other_candidates() -> list[Candidate]:
    """Lens models without an order, or that are compared at one."""
    return [
        Candidate("division", "division", None, lens_named("division")),
        Candidate("eucm", "eucm", None, lens_named("eucm")),
        Candidate("double-sphere", "double-sphere", None, lens_named("double-sphere")),
    ]


def rational_candidate() -> Candidate:
    """OpenCV's eight coefficients, over the polynomial of three and tangential terms."""
    return Candidate("opencv8", "rational", 3, lens_named("opencv8"), ("radial 3 + p",))


def named_candidates(names: Sequence[str]) -> list[Candidate]:
    """Candidates as the user names them: ``radial 2``, ``fisheye 3``, ``opencv5``, ``eucm``.

    Raises
    ------
    InputError
        Where a name is not known, or has no such order.
    """
    found: dict[str, Candidate] = {}
    for text in names:
        for candidate in _named(text):
            found.setdefault(candidate.name, candidate)
    if not found:
        raise InputError("lens: none is named; leave it out to have them found")
    return list(found.values())


def _named(text: str) -> list[Candidate]:
    words = text.replace(":", " ").replace("+", " + ").split()
    name, rest = (words[0], words[1:]) if words else ("", [])
    if name == "pinhole" and not rest:
        return radial_candidates(0)
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
        return [rational_candidate()]
    if not orders:
        return [Candidate(name, name, None, lens_named(name))]
    order = int(orders[0])
    if name == "radial":
        lens = lens_named(name, order=order, tangential=tangential)
        key = "pinhole" if order == 0 and not tangential else f"radial {order}{' + p' * tangential}"
        known = radial_candidates(order) if order else []
        parents = next((c.parents for c in known if c.name == key), ())
        return [Candidate(key, "radial", order, lens, parents)]
    if name == "fisheye":
        lens_named(name, order=order)
        return [fisheye_candidate(order)]
    return [Candidate(f"{name} {order}", name, order, lens_named(name, order=order))]
