"""How a figure writes a parameter's name."""

from __future__ import annotations

GREEK = ("alpha", "beta", "sigma", "tau", "nu")


def parameter_symbol(name: str) -> str:
    """Symbol of a parameter such as ``alpha_2``: Greek where it is a letter's name."""
    stem, _, index = name.partition("_")
    if stem not in GREEK or (index and not index.isdigit()):
        return name.replace("_", " ")
    return rf"$\{stem}_{{{index}}}$" if index else rf"$\{stem}$"


def parameter_label(name: str, unit: str) -> str:
    """Symbol with its unit: coefficients and sigma have the pixels', others none."""
    has_unit = name.partition("_")[0] in ("alpha", "beta", "sigma")
    return f"{parameter_symbol(name)} [{unit if has_unit else '1'}]"
