"""Pictures of a run."""
import numpy as np


def draw(trace, other=None):
    """See kilotouch.plot."""
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(8, 3.2), constrained_layout=True)
    axes.plot(trace.t, trace.f_n, color="C0", label="normal")
    axes.plot(trace.t, trace.f_t, color="C1", label="tangential")
    if other is not None:
        axes.plot(other.t, other.f_n, color="0.4", lw=1, ls="--", label="normal, other")
        axes.plot(other.t, other.f_t, color="0.6", lw=1, ls="--", label="tangential, other")
    slips = trace.mode >= 2
    if slips.any():
        axes.fill_between(trace.t, 0, 1, where=slips, transform=axes.get_xaxis_transform(), color="C1", alpha=0.12, lw=0,
                          label="slips")
    axes.set(xlabel="time [s]", ylabel="force on the tool [N]", xlim=(0, float(np.max(trace.t, initial=1e-3))))
    axes.legend(loc="upper left", frameon=False)
    return figure
