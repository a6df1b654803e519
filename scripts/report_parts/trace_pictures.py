"""force.png."""
import math

from report_parts.drawing import matplotlib, np, plt
from report_parts.palette import FORCE, LIMIT, NORMAL, TANGENTIAL
from report_parts.style import BLACK, GREY, MODES, PURPLE
from report_parts.words import figures
from report_parts.whole_file import save_figure


def mode_strip(axes, trace):
    """Shades the background by mode. One image of at most 1600 columns, each the mean colour of its ticks: a mode that
    changes every tick shows as a mixture, where thousands of rectangles would be slow and show only the last."""
    t, modes = trace["t"], trace["mode"]
    shades = {word: matplotlib.colors.to_rgb(colour) for word, (_, colour) in MODES.items()}
    rgb = np.array([shades.get(mode, (1, 1, 1)) for mode in modes])
    edges = np.unique(np.linspace(0, len(t), min(1600, len(t)) + 1).astype(int))
    strip = np.add.reduceat(rgb, edges[:-1], axis=0) / np.diff(edges)[:, None]
    alternates = (strip[1:-1] != strip[:-2]).any(axis=1) & (strip[1:-1] != strip[2:]).any(axis=1)
    mixed = len(strip) > 20 and alternates.mean() > 0.05
    if mixed:  # finer than the eye separates: smooth the strip, and say so in the legend
        width = max(3, len(strip) // 200)
        strip = np.stack([np.convolve(np.pad(c, width // 2, mode="edge"), np.ones(width) / width, "valid")[:len(strip)]
                          for c in strip.T], axis=1)
    low, high = axes.get_ylim()
    axes.imshow(strip[None], extent=(t[0], t[-1], low, high), aspect="auto", zorder=-5, interpolation="nearest")
    axes.set_ylim(low, high)
    patch = lambda colour, label: matplotlib.patches.Patch(facecolor=colour, edgecolor="#999999", linewidth=0.5, label=label)
    patches = [patch(colour, label) for word, (label, colour) in MODES.items() if (modes == word).any()]
    if mixed:
        patches.append(patch(strip[1:-1][alternates].mean(axis=0), "modes alternate"))
    return patches


def draw_forces(axes, trace, friction=None, modes=True, normal=NORMAL, labels=True):
    """Normal force solid, tangential dotted as in the paper, and the friction limit. Returns the legend's handles."""
    t = trace["t"]
    handles = axes.plot(t, trace["f_n"], color=normal, label="normal force $f_n$", zorder=3)
    handles += axes.plot(t, trace["f_t"], color=TANGENTIAL, ls=(0, (1, 0.8)), lw=1.9, label="tangential force $f_t$", zorder=4)
    if friction:
        names = {friction[0]: r"$\mu f_n$"} if friction[0] == friction[1] else {
            friction[0]: r"$\mu_s f_n$", friction[1]: r"$\mu_k f_n$"}
        for mu, name in names.items():
            if mu != 1:  # with mu = 1 the limit is the normal force itself
                handles += axes.plot(t, mu * trace["f_n"], color=LIMIT, lw=1.0, ls="--" if mu == friction[0] else "-.", label=f"{name}, $\\mu$ = {mu:g}"
                                     if friction[0] == friction[1] else f"{name} ({mu:g})", zorder=2)
    top = max(np.nanmax(trace["f_n"]), np.nanmax(trace["f_t"]))
    if not top > 0:
        top = 1.0
        axes.text(0.5, 0.5, "the tool does not touch the surface", ha="center", color=GREY, transform=axes.transAxes)
    axes.set_ylim(-0.03 * top, 1.08 * top)
    axes.set_xlim(t[0], t[-1])
    if labels:
        axes.set_ylabel("force on the tool [N]")
    return handles + (mode_strip(axes, trace) if modes else [])


def legend_below(figure, handles, columns):
    """One legend for all panels, in a strip of its own at the bottom."""
    rows = math.ceil(len(handles) / columns)
    strip = (0.18 + 0.25 * rows) / figure.get_figheight()  # inches
    figure.get_layout_engine().set(rect=(0, strip, 1, 1 - strip))
    figure.legend(handles=handles, loc="lower center", ncol=min(columns, len(handles)), fontsize=10)


def refresh_times(trace):
    return trace["t"][1:][np.diff(trace["model_frame"]) != 0]


def size_of_force(columns):
    return np.sqrt(sum(columns[f"force_{axis}"] ** 2 for axis in "xyz"))


def draw_whole_force(axes, trace, reference=None):
    """What the hand feels, differences between local models faded, and the reference's: that has no normal to split it by."""
    whole = size_of_force(trace)
    handles = axes.plot(trace["t"], whole, color=FORCE, lw=0.9, label="whole force, as felt", zorder=2)
    if reference is not None:
        handles += axes.plot(reference["t"], size_of_force(reference), color=FORCE, lw=2.4, alpha=0.35,
                             label="reference: whole force", zorder=2)
    low, high = axes.get_ylim()
    axes.set_ylim(low, max([high] + [1.08 * line.get_ydata().max() for line in handles]))
    return handles


def draw_second_tool(axes, trace):
    """Its normal and tangential force over those of the first one; the background tells the first one's mode."""
    t = trace["t"]
    handles = axes.plot(t, trace["f_n"], color=NORMAL, lw=1.2, ls=(0, (6, 2)), label="second tool: $f_n$", zorder=3)
    handles += axes.plot(t, trace["f_t"], color=TANGENTIAL, ls=(0, (5, 1.5, 1, 1.5)), lw=1.3, label="second tool: $f_t$", zorder=3)
    low, high = axes.get_ylim()
    axes.set_ylim(low, max(high, 1.08 * np.nanmax(trace["f_n"]), 1.08 * np.nanmax(trace["f_t"])))
    return handles


def indentation(trace):
    """[m]; not a number without contact. None from a folder of an older program."""
    if trace is None or "indentation" not in trace:
        return None
    return np.where(trace["mode"] == "free", np.nan, trace["indentation"])


def draw_force_figure(run, path):
    trace = run.trace
    depth, second = indentation(trace), indentation(run.second_trace)
    if depth is None:
        figure, top = plt.subplots(figsize=(10, 4.6), layout="constrained")
        bottom = None
    else:
        figure, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6.4), sharex=True, gridspec_kw={"height_ratios": [2.4, 1]}, layout="constrained")
    handles = draw_forces(top, trace, run.friction(), modes=False)
    if run.second_trace is not None:
        handles += draw_second_tool(top, run.second_trace)
    if run.second_trace is None or run.reference is not None:
        handles += draw_whole_force(top, trace, run.reference)
    handles += mode_strip(top, trace)
    refreshes = refresh_times(trace)
    if len(refreshes) > 1:
        every = f"new local model, mostly every {figures(1e3 * float(np.median(np.diff(refreshes))))} ms"
    if len(refreshes) > 200:  # ticks would be one grey band
        top.text(1.0, 1.02, every, transform=top.transAxes, ha="right", fontsize=10, color="#444444")
    elif len(refreshes) > 1:
        handles += top.plot(refreshes, np.full(len(refreshes), 0.012), ls="none", marker="|", ms=7, mew=0.8, color=PURPLE,
                            alpha=0.7, transform=top.get_xaxis_transform(), label=every, zorder=5)
    top.set_title("Force over time" if run.second_trace is None else "Force on both tools over time")
    legend_below(figure, handles, columns=4)

    if bottom is None:
        top.set_xlabel("time [s]")
    else:
        bottom.plot(trace["t"], 1e3 * depth, color=BLACK, label="surface pushed in, along the contact normal", zorder=3)
        if second is not None:
            bottom.plot(run.second_trace["t"], 1e3 * second, color=BLACK, lw=1.2, ls="--", label="… by the second tool", zorder=3)
        bottom.set_ylabel("indentation [mm]")
        bottom.set_xlabel("time [s]")
        low, high = bottom.get_ylim()
        bottom.set_ylim(min(0, low), high + 0.35 * (high - low))  # room for the legend
        mode_strip(bottom, trace)
        bottom.legend(loc="upper left", ncol=2, fontsize=10)
    save_figure(figure, path)
    plt.close(figure)
