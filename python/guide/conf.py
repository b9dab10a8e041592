"""The site, as Sphinx builds it: script/docs."""

import logging
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_site"))

import plain_docstrings
import pyvista

import surflux as sf

pyvista.OFF_SCREEN = True
logging.getLogger("surflux").setLevel(logging.WARNING)  # what is taken for granted of clouds is no fault of a page
plain_docstrings.public_names_stand_in_the_face()

project = "surflux"
author = "the surflux authors"
copyright = author
version = release = sf.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
templates_path = ["_site"]
exclude_patterns = ["_site", "examples", "gallery/*.ipynb", "gallery/*.zip"]
nitpicky = True
# Without the network there are no pages of others to refer to; rooms (surflux.scenes.lights) have no pages.
nitpick_ignore_regex = [(r"py:.*", r"(?!surflux).*|surflux\.[_a-z]\w*\..*")]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # the notebook is a test of its own

default_role = "code"
highlight_language = "none"
napoleon_custom_sections = [("Attributes", "params_style")]  # as arguments: pages of their own would name them twice
napoleon_attr_annotations = False
napoleon_use_rtype = False
autosummary_generate = True
autodoc_default_options = {"members": True, "inherited-members": True}
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "ignore_pattern": "__init__",
    "image_scrapers": ("gallery_pictures.pictures",),
    "reset_modules": (),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "capture_repr": (),
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e6,
    "write_computation_times": False,
    "remove_config_comments": True,
}

html_theme = "furo"
html_title = "surflux"
html_static_path = []
html_copy_source = False
html_show_sphinx = False


def setup(app):
    app.connect("autodoc-process-docstring", plain_docstrings.escape, priority=1)
