"""Colours and fonts of all pictures. Forces, modes and displacement have those of the palette; these are for all else."""
from report_parts.palette import tint

# Okabe-Ito colours: distinct for every kind of colour vision. The modes differ in lightness too, for grey prints.
BLACK, ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#D55E00", "#CC79A7")
GREY = "#777777"
MODES = {  # word in trace.csv -> (legend, shade)
    "free": ("no contact", tint("free")),
    "stick": ("stick", tint("stick")),
    "slide": ("slide, no friction", tint("slide")),
    "frictional_slide": ("slide with friction", tint("frictional_slide")),
}
STYLE = {
    "font.size": 11, "axes.titlesize": 12, "axes.titleweight": "bold", "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "figure.dpi": 130,
    "axes.grid": False, "figure.constrained_layout.w_pad": 0.1, "figure.constrained_layout.h_pad": 0.08, "lines.linewidth": 1.5, "path.simplify": True,
}
