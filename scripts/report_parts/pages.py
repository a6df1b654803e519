"""Pages: templates of the folder page/, filled by Jinja2, with every script and style inside, so that they can be mailed alone.

Whatever a file, a scene or a mesh is named, it is text: templates escape all that is no Markup, and data goes in as JSON.
"""
import base64
import os

from report_parts.inline import inline_json
from report_parts.notices import with_notice
from report_parts.palette import HERE, viewer_file
from report_parts.whole_file import write_whole

try:
    import jinja2
    from markupsafe import Markup
except ImportError:  # numbers and pictures are kept; only the pages are missing
    jinja2 = None
    Markup = str

LIBRARIES = {  # name -> (file of Debian's package, package)
    "Chart.js": ("/usr/share/javascript/chart.js/chart.min.js", "libjs-chart.js"),
    "three.js": ("/usr/share/javascript/three/three.min.js", "libjs-three"),
    "OrbitControls of three.js": ("/usr/share/javascript/three/examples/js/controls/OrbitControls.js", "libjs-three"),
}


def read_text(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def in_script(text):
    """No text of a script can end it or begin another."""
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def own(name):
    """A file of page/, for <script> or <style>."""
    return Markup(in_script(read_text(os.path.join(HERE, name))))


def viewer(name):
    """A file that `kilotouch view` has, too; an empty text where it is missing."""
    path = viewer_file(name)
    return Markup(in_script(read_text(path))) if path else Markup("")


def body_view():
    """The viewer of `kilotouch view`; an empty text where it or its libraries are missing."""
    return viewer("body_view.js") if library("three.js") and library("OrbitControls of three.js") else Markup("")


def library(name):
    """A JavaScript library with its licence, or an empty text where the package is missing."""
    try:
        return Markup(in_script(with_notice(name, read_text(LIBRARIES[name][0]))))
    except OSError:
        return Markup("")


def picture(folder, name):
    """A PNG as a data: URI, or an empty text."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return ""
    with open(path, "rb") as file:
        return Markup("data:image/png;base64," + base64.b64encode(file.read()).decode("ascii"))


def write_page(path, template, **values):
    """The template, filled, as a whole file. Without Jinja2 nothing: report.py says so at the end."""
    if jinja2 is None:
        return
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(HERE), autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.globals.update(own=own, viewer=viewer, body_view=body_view, library=library, packages={name: package for name, (_, package) in LIBRARIES.items()})
    environment.filters["json"] = lambda value: Markup(inline_json(value))
    write_whole(path, environment.get_template(template).render(**values) + "\n")
