"""Figures of a comparison: functions from results to matplotlib figures.

`registry.KINDS` lists the kinds; a kind is a module of this folder that offers ``draw``
and ``alt_text``. Nothing is imported here: the list must not cost matplotlib.
"""
