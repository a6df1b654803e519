"""Sphinx's settings for scripts/manual."""
project = "kilotouch"
author = "the kilotouch authors"
copyright = author  # no year: the same pages from the same commit
root_doc = "docs/index"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # pages begin a part where they like
highlight_language = "none"
html_theme = "furo"
html_title = "kilotouch"
html_static_path = ["static"]
html_css_files = ["manual.css"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
