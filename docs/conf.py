"""Configuration of the documentation site; `scripts/site` builds it."""

import os
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "site"))

import reference_pages

project = "handcart"
author = "the handcart developers"
copyright = author
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
]
exclude_patterns = ["site/*.py", "_build"]
myst_enable_extensions = ["colon_fence", "deflist", "fieldlist"]
myst_heading_anchors = 4

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autodoc_class_signature = "separated"
autodoc_preserve_defaults = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
default_role = "code"  # docstrings name code in single backquotes

html_theme = "furo"
html_title = "handcart"
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}


MARKDOWN_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(((?:\.\./)+[^)#\s]*)[^)]*\)")


def setup(app):
    """Write the reference pages first; name files outside docs/ instead of linking to them."""
    app.connect("builder-inited", lambda app: reference_pages.write(Path(app.srcdir) / "reference"))
    app.connect("source-read", name_files)


def name_files(app, page, source):
    """Replace links that lead out of docs/, which only readers of the repository can follow."""
    folder = os.path.dirname(page)

    def name(link):
        path = os.path.normpath(os.path.join("docs", folder, link[2]))
        if path.startswith("docs/"):
            return link[0]
        return link[1] if path in link[1] else f"{link[1]} (`{path}`)"

    source[0] = MARKDOWN_LINK.sub(name, source[0])
