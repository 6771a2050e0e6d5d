"""Fitted lenses as other tools take them, one module per format.

A module has NAME, COVARIANCE (whether the format has room for it), ``holds(lens)`` and
``text(camera)``; `bayescal.report.cameras.write` lists them.
"""
