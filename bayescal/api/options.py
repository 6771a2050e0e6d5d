"""The options that the public functions share: stated once, shown by each."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypedDict, TypeVar, get_type_hints

from bayescal.comparison.settings import Settings

# What numpydoc says of a parameter: its name and type, then, indented, its meaning.
ENTRY = re.compile(r"^([*\w]+) : .*\n(?: +.*\n)*", re.MULTILINE)

Function = TypeVar("Function", bound=Callable[..., Any])


class PolynomialOptions(TypedDict, total=False):
    """Types of the options of any polynomial; `Settings` has their meaning and defaults."""

    prior: str | None
    tau: float | None
    noise: str
    nu: float | None
    bad_offset: bool
    tolerance: float | None
    seed: int
    ess: int


class Options(PolynomialOptions, total=False):
    """Those of a camera's points, whose deviations may be one number or a word."""

    sigma: float | str | None


def spelled_out(options: type[PolynomialOptions]) -> Callable[[Function], Function]:
    """Let a function that takes ``**options`` show each of them in help and completion.

    Editors and mypy read ``Unpack[Options]``; help, IPython and Sphinx ask the function
    itself, and get here what a signature written out in full would have told them.

    Parameters
    ----------
    options : type
        The typed dictionary whose keys are taken.

    Returns
    -------
    callable
        Decorator; it returns the function itself, with ``__signature__`` and ``__doc__`` set.
    """
    taken = [field for field in fields(Settings) if field.name in get_type_hints(options)]
    shown = [
        inspect.Parameter(
            field.name, inspect.Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type
        )
        for field in taken
    ]
    entries = _entries(Settings.__doc__ or "")
    text = "".join(entries.get(field.name, "") for field in taken)

    def show(function: Function) -> Function:
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        told: Any = function
        told.__signature__ = signature.replace(parameters=[*own, *shown])
        if function.__doc__ is not None:
            written = inspect.cleandoc(function.__doc__)
            told.__doc__ = ENTRY.sub(lambda e: text if e[1] == "**options" else e[0], written)
        return function

    return show


def _entries(docstring: str) -> dict[str, str]:
    """Entries of a numpydoc docstring, by what they explain."""
    return {entry[1]: entry[0] for entry in ENTRY.finditer(inspect.cleandoc(docstring) + "\n")}
