"""What bayescal takes of emcee, whose import then takes a third of its time.

emcee.moves.kde imports scipy.stats and emcee.backends.hdf h5py, and both do without where there is
none. bayescal uses neither, so that there is none while emcee is imported: `./scripts/benchmark`
measures what that saves. Who else uses emcee in this process has both.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import threading
from collections.abc import Callable, Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

UNUSED = {"scipy.stats": ("emcee.moves.kde", "gaussian_kde"), "h5py": ("emcee.backends.hdf", "")}


class _Absent:
    """Finds no unused module, for the thread that made it alone."""

    def __init__(self) -> None:
        self._thread = threading.get_ident()
        self.missed: list[str] = []

    def find_spec(
        self,
        name: str,
        path: Sequence[str] | None = None,  # noqa: ARG002 - what an import asks with
        target: ModuleType | None = None,  # noqa: ARG002
    ) -> ModuleSpec | None:
        """Leave every other module to those who find it."""
        if name in UNUSED and threading.get_ident() == self._thread:
            self.missed.append(name)
            raise ModuleNotFoundError(f"{name} is not needed", name=name)
        return None


class _Later(ModuleType):
    """A module that is imported when something of it is wanted."""

    def __getattr__(self, name: str) -> Any:
        return getattr(importlib.import_module(self.__name__), name)


def _later(module: str, name: str) -> Callable[..., Any]:
    """Give a function of a module that is imported when it is called."""

    def call(*arguments: Any, **named: Any) -> Any:
        return getattr(importlib.import_module(module), name)(*arguments, **named)

    return call


def _import() -> None:
    """Import emcee without what is not used, and leave that for later."""
    absent = _Absent()
    sys.meta_path.insert(0, absent)
    try:
        importlib.import_module("emcee")
    finally:
        sys.meta_path.remove(absent)
    for missed in absent.missed:
        place, name = UNUSED[missed]
        if importlib.util.find_spec(missed) is not None:
            later = _later(missed, name) if name else _Later(missed)
            setattr(sys.modules[place], name or missed, later)


_import()

from emcee import EnsembleSampler  # noqa: E402
from emcee.autocorr import auto_window  # noqa: E402
from emcee.moves import DEMove, Move  # noqa: E402

__all__ = ["DEMove", "EnsembleSampler", "Move", "auto_window"]
