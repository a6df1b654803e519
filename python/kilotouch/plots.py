"""Pictures of a run, in the colours of the reports and of the live page (palette.css)."""
import os as _os
import re as _re

import numpy as np


def palette():
    """name -> "#0072B2" of each quantity, or the list of a ramp from 0 to the scale's end."""
    with open(_os.path.join(_os.path.dirname(__file__), "palette.css"), encoding="utf-8") as file:
        on_white = file.read().split("@media")[0]
    found = {name: value.split() for name, value in _re.findall(r"--([\w-]+):\s*([^;]+);", on_white)}
    return {name: colours[0] if len(colours) == 1 else colours for name, colours in found.items()}


def draw(trace, other=None):
    """See kilotouch.plot."""
    from matplotlib import pyplot
    colour = palette()
    figure, axes = pyplot.subplots(figsize=(8, 3.2), constrained_layout=True)
    axes.plot(trace.t, trace.f_n, color=colour["normal"], label="normal")
    axes.plot(trace.t, trace.f_t, color=colour["tangential"], label="tangential")
    if other is not None:
        axes.plot(other.t, other.f_n, color=colour["normal"], lw=1, ls="--", label="normal, other")
        axes.plot(other.t, other.f_t, color=colour["tangential"], lw=1, ls="--", label="tangential, other")
    slips = trace.mode >= 2
    if slips.any():
        axes.fill_between(trace.t, 0, 1, where=slips, transform=axes.get_xaxis_transform(), color=colour["frictional_slide"], alpha=0.3, lw=0,
                          label="slips")
    axes.set(xlabel="time [s]", ylabel="force on the tool [N]", xlim=(0, float(np.max(trace.t, initial=1e-3))))
    axes.legend(loc="upper left", frameon=False)
    return figure
