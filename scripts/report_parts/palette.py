"""The palette of quantities, palette.css of the live page: what it says is what pages, pictures and charts show."""
import os
import re

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page")
# In the source tree, and where an installed command has it.
VIEWERS = (os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(HERE))), "view", "page"), HERE)


def viewer_file(name):
    """A file that `kilotouch view` has, too; None where it is missing."""
    return next((path for path in (os.path.join(folder, name) for folder in VIEWERS) if os.path.exists(path)), None)


def read_palette():
    """name -> colours on white paper, as "#0072B2": one, or those of a ramp from 0 to the scale's end."""
    with open(viewer_file("palette.css"), encoding="utf-8") as file:
        on_white = file.read().split("@media")[0]
    return {name: value.split() for name, value in re.findall(r"--([\w-]+):\s*([^;]+);", on_white)}


PALETTE = read_palette()
NORMAL, TANGENTIAL, FORCE, LIMIT, TOOL = (PALETTE[name][0] for name in ("normal", "tangential", "force", "limit", "tool"))


def tint(name, share=0.3):
    """A colour mixed with white, for backgrounds."""
    parts = [int(PALETTE[name][0][i:i + 2], 16) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(255 + share * (part - 255)):02X}" for part in parts)
