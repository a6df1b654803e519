"""paper.png and paper.html: the three drag experiments and what is claimed of them."""
import html
import os

from report_parts.drawing import CAN_DRAW, matplotlib, plt
from report_parts.pages import page, picture, write_page
from report_parts.results import Run, read_json
from report_parts.style import BLACK, BLUE, GREY, VERMILION
from report_parts.trace_pictures import draw_forces, legend_below
from report_parts.words import PLAIN, percent, with_unit, written
from report_parts.whole_file import save_figure

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
    for trace, colour, width, label in ((paper, VERMILION, 1.2, "paper's law, identity metric"),
                                        (ours, BLUE, 2.2, "coulomb, implicit metric")):
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
    ("law", "law", PLAIN), ("metric", "metric", PLAIN), ("mu", "friction μ", PLAIN), ("buzz", "buzz above 100 Hz", percent), ("crossing_jump", "jump at a mesh line", percent),
    ("mean_n", "mean normal force", with_unit("N")), ("mean_t", "mean tangential force", with_unit("N")),
    ("max_n", "largest normal force", with_unit("N")), ("max_t", "largest tangential force", with_unit("N"))]


EXACT = "{:.9g}".format  # a claim may fail in the seventh digit


def law_table(rows):
    if not rows:
        return ""
    named = {key: (name, write) for key, name, write in LAW_COLUMNS}
    keys = [key for key, _, _ in LAW_COLUMNS if any(key in row for row in rows)]
    keys += [key for key in rows[0] if key not in keys]
    head = "".join(f"<th class='{'number' if key not in ('law', 'metric') else ''}'>{html.escape(named.get(key, (key, PLAIN))[0])}</th>" for key in keys)
    body = "".join("<tr>" + "".join(f"<td class='{'number' if not isinstance(row.get(key), str) else ''}'>"
                                    f"{written(row.get(key), named.get(key, (key, PLAIN))[1])}</td>" for key in keys) + "</tr>" for row in rows)
    return f"<h2>Laws side by side</h2><table class=laws><tr>{head}</tr>{body}</table>"


def claim_table(claims):
    if not claims:
        return ""
    rows = "".join(f"<tr><td>{html.escape(str(claim.get('text', '')))}</td><td class=number>{written(claim.get('value'), EXACT)}</td>"
                   f"<td class=number>{written(claim.get('bound'), EXACT)}</td>"
                   f"<td class={'good' if claim.get('holds') else 'bad'}>{'✓ holds' if claim.get('holds') else '✗ does not hold'}</td></tr>" for claim in claims)
    return f"<h2>Claims checked</h2><table class=claims><tr><th>claim</th><th class=number>measured</th><th class=number>bound</th><th>result</th></tr>{rows}</table>"


def paper_report(folder, title):
    runs = {name: Run(os.path.join(folder, name)) for name in ("slide", "stick", "stick_slip", "coulomb_slide", "coulomb")}
    data = read_json(folder, "paper.json") or {}
    if all(run.is_empty for run in runs.values()) and not data:
        raise SystemExit(f"report.py: {folder}: no folder slide, stick, stick_slip or coulomb with results there")
    if CAN_DRAW:
        draw_paper(runs, os.path.join(folder, "paper.png"))
    claims = data.get("claims") or []
    held = sum(1 for claim in claims if claim.get("holds"))
    subtitle = f"{held} of {len(claims)} claims hold" if claims else ""
    body = picture(folder, "paper.png", "Top: the paper's three drag experiments. Bottom: one transition from stick to slip, and the end of "
                   "the drag without and with friction: the paper's law and the consistent law, one over the other.") if CAN_DRAW else ""
    body += claim_table(claims) + law_table(data.get("table") or [])
    commands = [str(run.summary["command"]) for run in runs.values() if run.summary.get("command")]
    if data.get("command") or commands:
        lines = [str(data["command"])] if data.get("command") else commands
        body += f"<h2>Run it again</h2><pre>{html.escape(chr(10).join(lines))}</pre>"
    write_page(os.path.join(folder, "paper.html"), page(title or "The paper's drag experiments", subtitle, body))
