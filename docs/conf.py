"""Sphinx's settings; ``make docs`` builds the site into ``docs/_build``. It needs no network, nor do its pages."""

import importlib.metadata
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

project = "gabf-planner"
author = "the gabf-planner authors"
version = release = importlib.metadata.version("gabf-planner")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "site_parts"]
templates_path = ["_templates"]
autosummary_imported_members = True  # public names live in modules below their package
exclude_patterns = ["_build", "notebooks/pictures"]
myst_enable_extensions = ["dollarmath", "deflist", "fieldlist"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # the notebooks are shown as they are kept; the test suite runs them

html_theme = "furo"
html_title = "gabf-planner"
html_static_path = ["_static"]
html_extra_path = ["_build/extra"]  # the pages of the gallery, which site_parts makes
(Path(__file__).parent / html_extra_path[0]).mkdir(parents=True, exist_ok=True)  # Sphinx looks for it first
html_css_files = ["wrapped.css"]
html_math_renderer = "mathml"
html_show_copyright = False

autodoc_member_order = "groupwise"
autodoc_typehints = "signature"
autodoc_type_aliases = {name: name for name in ("Floats", "Ints", "Bools", "Thing")}
