"""Settings of the documentation's site: ./scripts/site builds it."""

import bayescal

project, author, copyright = "bayescal", "The bayescal developers", "the bayescal developers, MIT"
version = release = bayescal.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["conf.py", "images"]
html_theme, html_title = "furo", f"bayescal {version}"
# The walk-through is executed by the tests; the site shows the outputs it has.
nb_execution_mode = "off"
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
napoleon_google_docstring = False
napoleon_use_ivar = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"


def list_public_names(_app, page, source):
    """Put every public name on the page about Python, functions first."""
    if page != "api":
        return
    names = [name for name in bayescal.__all__ if not name.startswith("_")]
    functions = [f".. autofunction:: {name}" for name in names if name[0].islower()]
    classes = [f".. autoclass:: {name}\n   :members:" for name in names if name[0].isupper()]
    source[0] = source[0].replace("THE_PUBLIC_NAMES", "\n".join([*functions, "", *classes]))


def setup(app):
    """Make the page about Python as it is read."""
    app.connect("source-read", list_public_names)
