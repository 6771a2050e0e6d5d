"""The reduction of many points, kept in a run beside the sample of them."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from bayescal.arrays import frozen
from bayescal.polynomials.basis import Domain
from bayescal.polynomials.whole import Triangle, Whole

REDUCTION = "reduction.npz"
_WHOLE = ("n", "order", "distinct", "log_sd")
_SCALARS = ("tail", "largest")


def reduction_bytes(whole: Mapping[str, Whole]) -> bytes:
    """Encode the reduction of every axis, as an archive of NumPy that holds no pickle."""
    arrays: dict[str, Any] = {}
    for axis, found in whole.items():
        arrays |= {f"{axis}/{name}": getattr(found, name) for name in _WHOLE}
        for name in ("domain", "readings", "across"):
            interval = getattr(found, name)
            if interval is not None:
                arrays[f"{axis}/{name}"] = [interval.lower, interval.upper]
        for name in ("plain", "weighted"):
            triangle = getattr(found, name)
            if triangle is not None:
                arrays[f"{axis}/{name}"] = np.column_stack([triangle.r, triangle.qt])
                arrays[f"{axis}/{name}/scale"] = [getattr(triangle, s) for s in _SCALARS]
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def parse_reduction(raw: bytes) -> dict[str, Whole]:
    """Undo it; ValueError or KeyError where something is missing."""
    with np.load(io.BytesIO(raw), allow_pickle=False) as arrays:
        axes = list(dict.fromkeys(name.split("/")[0] for name in arrays.files))

        def triangle(place: str) -> Triangle | None:
            if place not in arrays.files:
                return None
            both, scale = arrays[place], arrays[f"{place}/scale"].tolist()
            return Triangle(frozen(both[:, :-1]), frozen(both[:, -1]), *scale)

        out = {}
        for axis in axes:
            plain = triangle(f"{axis}/plain")
            if plain is None:
                raise ValueError(f"lacks {axis}/plain")
            n, order, distinct, log_sd = (arrays[f"{axis}/{name}"].item() for name in _WHOLE)
            domain, readings, *across = (
                Domain(*arrays[f"{axis}/{name}"].tolist())
                for name in ("domain", "readings", "across")
                if name != "across" or f"{axis}/across" in arrays.files
            )
            weighted = triangle(f"{axis}/weighted")
            out[axis] = Whole(
                n, order, domain, readings, distinct, plain, weighted, log_sd, *across
            )
    return out
