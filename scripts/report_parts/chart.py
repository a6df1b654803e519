"""Speed against accuracy: chart.html, and a picture of each chart, from the chart.json of `kilotouch chart`."""
import json
import math
import os
import textwrap

from report_parts.drawing import CAN_DRAW, plt
from report_parts.pages import picture, write_page
from report_parts.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION
from report_parts.whole_file import save_figure

FAMILIES = {  # colour, matplotlib's marker, Chart.js's
    "ours": (BLACK, "*", "star"), "reducer": (BLUE, "o", "circle"), "baseline": (VERMILION, "X", "crossRot"),
    "global integrator": (GREEN, "s", "rect"), "local integrator": (SKY, "D", "rectRot"),
    "contact law": (PURPLE, "^", "triangle"), "collision backend": (GREY, "P", "cross"), "refresh": (ORANGE, "v", "rectRounded"),
    "springs": (BLUE, "o", "circle"), "4-node elements": (ORANGE, "s", "rect"), "10-node elements": (GREEN, "D", "rectRot"),
}
NAMES = {BLACK: "ink", BLUE: "blue", VERMILION: "vermilion", GREEN: "green", SKY: "sky", PURPLE: "purple", GREY: "grey", ORANGE: "orange"}  # in style.css
TICK_LIMIT_US = 1000.0  # a haptic period at 1 kHz


def family_of(chart, point):
    """What a point's colour tells: its method; where only bodies differ, its kind of body."""
    return point["body"].split(",")[0] if point["family"] == "mesh" else point["family"]


def is_number(value):
    return isinstance(value, (int, float)) and math.isfinite(value) and value > 0


def front_of(points, cost, error):
    """The points that none beats in both, by rising cost."""
    best, out = math.inf, []
    for point in sorted((p for p in points if is_number(p[cost]) and is_number(p[error])), key=lambda p: (p[cost], p[error])):
        if point[error] < best:
            best = point[error]
            out.append(point)
    return out


FAILED = 1000  # %: larger errors are drawn here, with their number; they would squeeze all others


def short(point):
    return point["body"] + (", refined" if point["refined"] else "") if point["family"] == "mesh" else point["label"]


def is_hollow(point):
    """Bodies are drawn filled with refined cells, hollow as they are."""
    return point["family"] == "mesh" and not point["refined"]


def panels_of(chart):
    """Points that share a truth belong into one picture."""
    if any(truth["body"] == "all" for truth in chart["references"]):
        return [("all bodies", chart["points"])]
    return [(truth["body"], [p for p in chart["points"] if p["body"] == truth["body"]]) for truth in chart["references"]]


def truth_line(chart, body):
    for truth in chart["references"]:
        if truth["body"] in (body, "all"):
            change = truth.get("change_by_halving")
            return f"truth: {truth['what']}" + (f"; halving its step changed it by {100 * change:.2g} %" if is_number(change) else "")
    return ""


def draw_panel(axes, points, cost, error, titles, jnd):
    families = {}
    for point in points:
        if is_number(point[cost]) and is_number(point[error]):
            families.setdefault(family_of(None, point), []).append(point)
    for name in FAMILIES:
        if name in families:
            colour, marker, _ = FAMILIES[name]
            size, above = (110, 4) if name == "ours" else (42, 3)
            hollow, filled = [p for p in families[name] if is_hollow(p)], [p for p in families[name] if not is_hollow(p)]
            axes.scatter([p[cost] for p in filled], [min(p[error], FAILED) for p in filled], c=colour, marker=marker, s=size,
                         label=name + (", refined" if hollow else ""), zorder=above, linewidths=0.5, edgecolors="white" if marker not in "xX" else None)
            if hollow:
                axes.scatter([p[cost] for p in hollow], [min(p[error], FAILED) for p in hollow], facecolors="none", marker=marker, s=size,
                             label=name + ", as they are", zorder=above, linewidths=1.2, edgecolors=colour)
    front = front_of(points, cost, error)
    if front:
        axes.step([p[cost] for p in front], [p[error] for p in front], where="post", color=GREY, lw=1.2, ls="-", zorder=2)
    for point in points:
        if is_number(point[cost]) and is_number(point[error]) and point[error] > FAILED:
            axes.annotate(f"{short(point)}: {point[error]:.2g} %", (point[cost], FAILED), textcoords="offset points", xytext=(-8, -3), ha="right", fontsize=8.5)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.axhline(100 * jnd, color=VERMILION, lw=1, ls="--", zorder=1)
    axes.annotate("noticeable: 10 %", (1, 100 * jnd), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=9, color=VERMILION)
    if cost.startswith("tick"):
        axes.axvline(TICK_LIMIT_US, color=VERMILION, lw=1, ls="--", zorder=1)
        axes.annotate("1 ms", (TICK_LIMIT_US, 0.02), xycoords=("data", "axes fraction"), ha="right", fontsize=9, color=VERMILION, rotation=90)
    axes.set_xlabel(titles[cost])
    axes.set_ylabel(titles[error])
    axes.margins(0.08, 0.12)
    label_points(axes, points, front, cost, error)


def label_points(axes, points, front, cost, error):
    """Names beside what the engine chooses by itself and the front, those that would lie on one another left out."""
    axes.figure.canvas.draw()
    taken = []
    ours = [p for p in points if p["is_ours"] and is_number(p[cost]) and is_number(p[error])]
    for point in ours + [p for p in front if not p["is_ours"]]:
        x, y = axes.transData.transform((point[cost], point[error]))
        if any(abs(x - u) < 150 and abs(y - v) < 16 for u, v in taken):
            continue
        taken.append((x, y))
        is_right = axes.transAxes.inverted().transform((x, y))[0] > 0.66
        axes.annotate(short(point), (point[cost], point[error]), textcoords="offset points", xytext=(-6 if is_right else 6, 5),
                      ha="right" if is_right else "left", fontsize=8.5)


def draw_chart(folder, chart, titles, jnd):
    """One row a truth: error against the tick, and against all work for a simulated second."""
    panels = panels_of(chart)
    figure, all_axes = plt.subplots(len(panels), 2, figsize=(13, 5.2 * len(panels) + 0.9), squeeze=False, layout="constrained")
    for (name, points), row in zip(panels, all_axes):
        for axes, cost in zip(row, ("tick_p50_us", "cpu_s_per_s")):
            draw_panel(axes, points, cost, "force_error", titles, jnd)
        row[0].set_title(name)
        row[1].set_title("\n".join(textwrap.wrap(truth_line(chart, name), 75)), fontsize=9.5, fontweight="normal", color="#444444")
    figure.suptitle(chart["title"], fontsize=13)
    handles = {}
    for axes in all_axes.flat:
        handles.update(dict(zip(*reversed(axes.get_legend_handles_labels()))))
    # matplotlib 3.6 cannot lay a figure's legend outside: room is left below.
    figure.get_layout_engine().set(rect=(0, 0.5 / figure.get_figheight(), 1, 1 - 0.5 / figure.get_figheight()))
    if handles:  # none: no run of it has an error to draw, as when its truth failed
        rows = 2 if sum(map(len, handles)) > 110 else 1
        figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=math.ceil(len(handles) / rows), fontsize=11 - rows)
    for extension in ("png", "svg"):
        save_figure(figure, os.path.join(folder, f"chart_{chart['name']}.{extension}"))
    plt.close(figure)


def chart_page(folder, document):
    data = {"axes": document["axes"], "noticeable": document["noticeable"], "charts": [], "styles": {name: (NAMES[colour], style) for name, (colour, _, style) in FAMILIES.items()}}
    for chart in document["charts"]:
        panels = [{"name": name, "truth": truth_line(chart, name), "points": [dict(p, group=family_of(chart, p)) for p in points]}
                  for name, points in panels_of(chart)]
        data["charts"].append({"title": chart["title"], "panels": panels})
    runs = sum(len(c["points"]) for c in document["charts"])
    write_page(os.path.join(folder, "chart.html"), "chart.html", title="Speed against accuracy", data=data,
               subtitle=f"{runs} runs in {document['seconds'] / 60:.1f} minutes on {document['processor']}; costs are CPU times",
               stills=[still for still in (picture(folder, f"chart_{chart['name']}.png") for chart in document["charts"]) if still])


def chart_report(folder):
    with open(os.path.join(folder, "chart.json"), encoding="utf-8") as file:
        document = json.load(file)
    document["charts"] = [chart for chart in document["charts"] if chart["points"]]  # stopped before: nothing to draw
    titles = {axis["key"]: axis["title"] for axis in document["axes"]}
    if CAN_DRAW:
        for chart in document["charts"]:
            draw_chart(folder, chart, titles, document["noticeable"])
    chart_page(folder, document)
