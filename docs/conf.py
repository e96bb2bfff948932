"""Settings of the site; `python -m tools.docs site` prepares its pages and builds it."""

from __future__ import annotations

import ngcell

project, author, copyright = "ngcell", "The ngcell authors", "2026, the ngcell authors"
version = release = ngcell.__version__

extensions = [
    "myst_parser",            # pages in Markdown, which GitHub shows as well
    "sphinx.ext.autodoc",     # the Python reference, from docstrings
    "sphinx.ext.napoleon",    # which are numpydoc
    "sphinx_click",           # the commands
    "sphinx_copybutton",      # a button at each block of code
    "tools.docs.mathml",      # equations without scripts or network
]  # fmt: skip
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = f"ngcell {release}"
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False

autodoc_typehints = "none"  # types, shapes and units are in the sections on parameters
napoleon_use_param = False  # parameters in one list, as they are written
napoleon_use_rtype = False
add_module_names = False
#: Types in docstrings are words, such as "array of float, shape (2,)"; only names of this package are links.
nitpick_ignore_regex = [("py:.*", r"(?!ngcell\.).*")]
