"""Figures: functions from results to matplotlib figures.

`registry.FIGURES` lists the kinds; a kind is a module, in the folder of the result it is of, that
offers ``draw`` and ``alt_text``. Nothing is imported here: the list must not cost matplotlib.
"""
