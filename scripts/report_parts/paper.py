"""paper.png and paper.html: the three drag experiments and what is claimed of them."""
import os

from report_parts.drawing import CAN_DRAW, matplotlib, np, plt
from report_parts.charts import MODES, curve_chart, mode_bands
from report_parts.pages import picture, write_page
from report_parts.results import Run, read_json
from report_parts.style import BLACK, GREY, PURPLE
from report_parts.trace_pictures import draw_forces, legend_below
from report_parts.words import FORCE, LENGTH, PLAIN, percent, with_unit, written
from report_parts.whole_file import save_figure

FOLDERS = ("slide", "stick", "stick_slip", "slide_extended", "stick_extended", "stick_slip_extended", "coulomb_slide", "coulomb")
EXPERIMENTS = [("slide", "Pure sliding (figure 3)"), ("stick", "Pure sticking (figure 4)"), ("stick_slip", "Stick-slip, µ = 1 (figure 5)")]


def empty_panel(axes, words):
    axes.set_axis_off()
    axes.text(0.5, 0.5, words, ha="center", va="center", color=GREY, transform=axes.transAxes)


def largest_slip(trace, ticks=10):
    """The transition, after that many ticks of sticking, with the largest drop of f_t in as many after; None without."""
    stuck, f_t = trace["mode"] == "stick", trace["f_t"]
    slips = [i for i in range(ticks, len(f_t)) if trace["mode"][i] == "frictional_slide" and stuck[i - ticks:i].all()]
    return max(slips, key=lambda i: f_t[i - 1] - f_t[i:i + ticks].min()) if slips else None


def draw_slip(axes, trace):
    """Zoom on one transition, marked by an arrow."""
    at = largest_slip(trace)
    if at is None:
        empty_panel(axes, "no stick → slip transition in this run")
        return
    low, high = max(0, at - 60), min(len(trace["t"]), at + 60)
    part = {name: column[low:high] for name, column in trace.items()}
    draw_forces(axes, part)
    top = axes.get_ylim()[1]
    x, y = trace["t"][at - 1], trace["f_t"][at - 1]
    axes.annotate("sticks until here,\nthen slips", xy=(x, y), xytext=(0.60, 0.07), textcoords="axes fraction", fontsize=10,
                  arrowprops={"arrowstyle": "-|>", "color": BLACK, "lw": 1.4, "shrinkB": 3}, zorder=6)
    axes.set_ylim(axes.get_ylim()[0], top)


# Name of the run with the paper's law, of ours beside it, and the panel's title.
BESIDE = [("slide", "coulomb_slide", "Normal force, µ = 0: the chatter"), ("stick_slip", "coulomb", "Normal force, µ = 1")]


def draw_beside(axes, paper, ours, length=0.3):
    """Normal forces of both laws at the end of the run, where the drag is steady."""
    handles = []
    for trace, colour, width, label in ((paper, BLACK, 1.2, "paper: its law and method"),
                                        (ours, PURPLE, 2.2, "coulomb, extended method")):
        keep = trace["t"] >= trace["t"][-1] - length
        handles += axes.plot(trace["t"][keep], trace["f_n"][keep], color=colour, lw=width, label=label)
    axes.set_ylabel("normal force $f_n$ [N]")
    axes.set_ylim(bottom=0)
    axes.legend(handles=handles, loc="lower left", fontsize=10)


def draw_paper(runs, path):
    figure, axes = plt.subplots(2, 3, figsize=(14, 8), layout="constrained")
    handles = {}
    for panel, (name, title) in zip(axes[0], EXPERIMENTS):
        trace = runs[name].trace
        panel.set_title(title)
        if trace is None:
            empty_panel(panel, f"no trace.csv in {name}/")
            continue
        handles.update((handle.get_label(), handle) for handle in draw_forces(panel, trace))
    axes[1, 0].set_title("One transition of stick-slip")
    if runs["stick_slip"].trace is not None:
        draw_slip(axes[1, 0], runs["stick_slip"].trace)
    else:
        empty_panel(axes[1, 0], "no trace.csv in stick_slip/")
    for panel, (paper, ours, title) in zip(axes[1, 1:], BESIDE):
        panel.set_title(title)
        missing = [name for name in (paper, ours) if runs[name].trace is None]
        if missing:
            empty_panel(panel, f"no trace.csv in {missing[0]}/")
        else:
            draw_beside(panel, runs[paper].trace, runs[ours].trace)
    for panel in axes.flat:
        panel.set_xlabel("time [s]")
        panel.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(5))
    legend_below(figure, list(handles.values()), columns=8)
    save_figure(figure, path)
    plt.close(figure)


LAW_COLUMNS = [  # (key in paper.json's table, name, how to write it)
    ("method", "method", PLAIN), ("law", "law", PLAIN), ("metric", "metric", PLAIN), ("mu", "friction μ", PLAIN), ("buzz", "buzz above 100 Hz", percent), ("crossing_jump", "jump at a mesh line", percent),
    ("mean_n", "mean normal force", FORCE), ("mean_t", "mean tangential force", FORCE),
    ("max_n", "largest normal force", FORCE), ("max_t", "largest tangential force", FORCE),
    ("reducer", "local model", PLAIN), ("refresh_hz", "refreshes a second", "{:.0f}".format),
    ("refresh_jump", "jump at a refresh", percent), ("penetration_max_m", "deepest penetration", LENGTH), ("step_us_p50", "tick, median", with_unit("µs"))]


WORDS = ("method", "law", "metric", "integrator", "reducer")
EXACT = "{:.9g}".format  # a claim may fail in the seventh digit


def law_rows(rows):
    """(columns, rows of texts); a column is (name, is it a number)."""
    named = {key: (name, write) for key, name, write in LAW_COLUMNS}
    keys = [key for key, _, _ in LAW_COLUMNS if any(key in row for row in rows)]
    rows = [dict(row, reducer=str(row["reducer"]).split(" {")[0]) if "reducer" in row else row for row in rows]  # without its frequencies
    return ([(named[key][0], key not in WORDS) for key in keys], [[written(row.get(key), named[key][1]) for key in keys] for row in rows])


def claim_rows(claims):
    return [{"text": str(claim.get("text", "")), "value": written(claim.get("value"), EXACT), "bound": written(claim.get("bound"), EXACT), "holds": bool(claim.get("holds"))} for claim in claims]


def force_curves(trace, keep=slice(None)):
    return [("normal force", "normal", trace["f_n"][keep], {"width": 2}), ("tangential force", "tangential", trace["f_t"][keep], {"width": 2, "dash": [2, 2]})]


def charts(runs):
    """The panels of paper.png, to look into."""
    out = []
    for name, title in EXPERIMENTS:
        trace = runs[name].trace
        if trace is not None:
            modes = {word: words for word, words in MODES.items() if (trace["mode"] == word).any()}
            out.append(curve_chart(title, trace["t"], force_curves(trace), "[N]", bands=mode_bands(trace["t"], trace["mode"]), modes=modes))
    trace = runs["stick_slip"].trace
    at = largest_slip(trace) if trace is not None else None
    if at is not None:
        part = slice(max(0, at - 60), at + 60)
        t = trace["t"][part]
        out.append(curve_chart("One transition of stick-slip", t, force_curves(trace, part), "[N]", bands=mode_bands(t, trace["mode"][part]),
                               marks=[{"x": float(trace["t"][at - 1]), "colour": "ink", "dash": [3, 3], "words": "sticks until here"}]))
    for paper, ours, title in BESIDE:
        one, other = runs[paper].trace, runs[ours].trace
        if one is not None and other is not None:
            keep = one["t"] >= one["t"][-1] - 0.3
            beside = np.interp(one["t"][keep], other["t"], other["f_n"])
            out.append(curve_chart(title, one["t"][keep], [("paper: its law and method", "ink", one["f_n"][keep], {"width": 1}),
                                                           ("coulomb, extended method", "purple", beside, {"width": 2.4})], "[N]"))
    return out


def paper_report(folder, title):
    runs = {name: Run(os.path.join(folder, name)) for name in FOLDERS}
    data = read_json(folder, "paper.json") or {}
    if all(run.is_empty for run in runs.values()) and not data:
        raise SystemExit(f"report.py: {folder}: no folder slide, stick, stick_slip or coulomb with results there")
    if CAN_DRAW:
        draw_paper(runs, os.path.join(folder, "paper.png"))
    claims = data.get("claims") or []
    held = sum(1 for claim in claims if claim.get("holds"))
    commands = [str(data["command"])] if data.get("command") else [str(run.summary["command"]) for run in runs.values() if run.summary.get("command")]
    columns, rows = law_rows(data.get("table") or [])
    write_page(os.path.join(folder, "paper.html"), "paper.html", title=title or "The paper's drag experiments",
               subtitle=f"{held} of {len(claims)} claims hold" if claims else "", charts=charts(runs) if CAN_DRAW else [],
               still=picture(folder, "paper.png") if CAN_DRAW else "", claims=claim_rows(claims), columns=columns, rows=rows, command="\n".join(commands))
