"""The pictures of stability maps and stability.html: where each method works, degrades or fails."""
import csv
import math
import os

from report_parts.drawing import CAN_DRAW, matplotlib, np, plt
from report_parts.charts import short
from report_parts.pages import picture, write_page
from report_parts.results import read_json
from report_parts.style import BLACK, BLUE, GREY, ORANGE, VERMILION
from report_parts.trace_pictures import legend_below
from report_parts.whole_file import save_figure

VERDICTS = {  # word -> (shade of the region, colour of the points, marker, legend)
    "works": ("#DCEFE6", "#009E73", "o", "works"),
    "degrades": ("#FBE8C4", ORANGE, "s", "degrades: off by more than 10 %, or buzz"),
    "fails": ("#F6D3C4", VERMILION, "X", "fails"),
}
ORDER = list(VERDICTS)


def read_table(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def number(word):
    try:
        return float(word)
    except (TypeError, ValueError):
        return math.nan


class StabilityMap:
    """One map of a result folder: its axes, points and lines."""

    def __init__(self, folder, facts):
        self.facts = facts
        self.name, self.title = facts["name"], facts["title"]
        self.points = read_table(os.path.join(folder, self.name + ".csv"))
        for p in self.points:
            p["x"], p["y"], p["value"] = number(p["x"]), number(p["y"]), number(p["value"])
            p["predicted_failure"] = p["predicted_failure"] == "1"
        self.lines = {}
        for row in read_table(os.path.join(folder, self.name + "_boundaries.csv")):
            key = (row["series"], row["label"], row["theory"] == "1")
            self.lines.setdefault(key, []).append((number(row["x"]), number(row["y"])))
        self.series = list(dict.fromkeys(p["series"] for p in self.points))

    def axis(self, which):
        """Limits over all points, with room, and the function that makes the axis even."""
        is_log = self.facts[which + "_log"]
        values = [p[which] for p in self.points if math.isfinite(p[which]) and (p[which] > 0 or not is_log)]
        low, high = (min(values), max(values)) if values else (1, 2)
        scale = (lambda v: np.log10(np.maximum(v, 1e-300))) if is_log else (lambda v: np.asarray(v, dtype=float))
        a, b = float(scale(low)), float(scale(high))
        room = 0.06 * (b - a) if b > a else 0.5
        back = (lambda v: 10.0 ** v) if is_log else (lambda v: v)
        return back(a - room), back(b + room), scale, is_log


def shade_regions(axes, points, x_axis, y_axis, cells=160):
    """Every place in the verdict of the nearest run: what lies between the runs is not claimed to be known better."""
    low_x, high_x, scale_x, log_x = x_axis
    low_y, high_y, scale_y, log_y = y_axis
    sx, sy = scale_x([low_x, high_x]), scale_y([low_y, high_y])
    px = (scale_x([p["x"] for p in points]) - sx[0]) / (sx[1] - sx[0])
    py = (scale_y([p["y"] for p in points]) - sy[0]) / (sy[1] - sy[0])
    codes = np.array([ORDER.index(p["verdict"]) for p in points])
    centres = (np.arange(cells) + 0.5) / cells
    # Rays run along one axis, a few of them: the ray nearest along the other axis decides first.
    across_x = len(set(np.round(px, 9))) <= len(set(np.round(py, 9)))
    wx, wy = (4.0, 1.0) if across_x else (1.0, 4.0)
    gx, gy = np.meshgrid(centres, centres)
    best = np.full(gx.shape, np.inf)
    code = np.zeros(gx.shape, dtype=int)
    for x, y, c in zip(px, py, codes):
        distance = (wx * (gx - x)) ** 2 + (wy * (gy - y)) ** 2
        nearer = distance < best
        best[nearer], code[nearer] = distance[nearer], c
    edges = np.linspace(0, 1, cells + 1)
    to_x = sx[0] + edges * (sx[1] - sx[0])
    to_y = sy[0] + edges * (sy[1] - sy[0])
    to_x, to_y = (10.0 ** to_x if log_x else to_x), (10.0 ** to_y if log_y else to_y)
    colours = matplotlib.colors.ListedColormap([VERDICTS[v][0] for v in ORDER])
    axes.pcolormesh(to_x, to_y, code, cmap=colours, vmin=-0.5, vmax=2.5, shading="flat", rasterized=True, zorder=0)


def draw_panel(axes, one, series, x_axis, y_axis, styles):
    points = [p for p in one.points if p["series"] == series and math.isfinite(p["x"]) and math.isfinite(p["y"])]
    axes.set_xscale("log" if x_axis[3] else "linear")
    axes.set_yscale("log" if y_axis[3] else "linear")
    axes.set_xlim(x_axis[0], x_axis[1])
    axes.set_ylim(y_axis[0], y_axis[1])
    if points:
        shade_regions(axes, points, x_axis, y_axis)
    for verdict, (_, colour, marker, _) in VERDICTS.items():
        chosen = [p for p in points if p["verdict"] == verdict]
        axes.scatter([p["x"] for p in chosen], [p["y"] for p in chosen], s=13, marker=marker, color=colour, linewidths=0, zorder=3)
    # What the engine got wrong stands out: failures that nothing announced, and alarms over nothing.
    silent = [p for p in points if p["verdict"] == "fails" and not p["predicted_failure"]]
    false = [p for p in points if p["verdict"] == "works" and p["predicted_failure"]]
    axes.scatter([p["x"] for p in silent], [p["y"] for p in silent], s=46, marker="o", facecolors="none", edgecolors=BLACK, linewidths=1.1, zorder=4)
    axes.scatter([p["x"] for p in false], [p["y"] for p in false], s=46, marker="D", facecolors="none", edgecolors=BLUE, linewidths=1.1, zorder=4)
    for (owner, label, theory), line in one.lines.items():
        if owner not in (series, ""):
            continue
        x, y = zip(*line)
        axes.plot(x, y, zorder=5, **styles[(label, theory)])


def line_styles(one):
    """One look for a label in all panels: theory dashed and dark, measured solid."""
    styles, measured, theory = {}, iter([BLACK, BLUE, "#CC79A7", GREY] * 4), iter([BLUE, VERMILION, "#6A3D9A", GREY] * 4)
    for _, label, is_theory in one.lines:
        if (label, is_theory) in styles:
            continue
        styles[(label, is_theory)] = ({"color": next(theory), "linestyle": (0, (4, 2)), "lw": 2.0, "label": label} if is_theory else
                                      {"color": next(measured), "linestyle": "-", "lw": 1.3, "marker": "|", "ms": 4, "label": label + ("" if "measured" in label else " (measured)")})
    return styles


def layout(series):
    """Series "row | column" as a table of panels, others one after the other. [(row, column, series, title)], rows, columns"""
    if len(series) > 1 and all(" | " in s for s in series):
        rows = list(dict.fromkeys(s.split(" | ")[0] for s in series))
        columns = list(dict.fromkeys(s.split(" | ")[1] for s in series))
        return [(rows.index(s.split(" | ")[0]), columns.index(s.split(" | ")[1]), s, None) for s in series], rows, columns
    width = min(3, len(series)) if len(series) != 4 else 2
    height = -(-len(series) // max(1, width))
    return [(i // width, i % width, s, s) for i, s in enumerate(series)], [None] * height, [None] * width


def legend(figure, one, styles):
    handles = []
    for verdict, (shade, colour, marker, words) in VERDICTS.items():
        if any(p["verdict"] == verdict for p in one.points):
            handles.append(matplotlib.lines.Line2D([], [], color=colour, marker=marker, linestyle="", ms=6, label=words))
    if any(p["verdict"] == "fails" and not p["predicted_failure"] for p in one.points):
        handles.append(matplotlib.lines.Line2D([], [], marker="o", mfc="none", mec=BLACK, linestyle="", ms=8, label="failed without having been predicted"))
    if any(p["verdict"] == "works" and p["predicted_failure"] for p in one.points):
        handles.append(matplotlib.lines.Line2D([], [], marker="D", mfc="none", mec=BLUE, linestyle="", ms=7, label="predicted to fail, but works"))
    handles += [matplotlib.lines.Line2D([], [], **style) for style in styles.values()]
    legend_below(figure, handles, 2 if len(handles) > 3 else 3)


def draw_map(one, stem):
    panels, rows, columns = layout(one.series)
    wide, high = (4.6, 3.9) if len(columns) <= 3 else (3.1, 2.5)
    size = (max(7.0, wide * len(columns) + 0.7), high * len(rows) + 2.0)
    figure, grid = plt.subplots(len(rows), len(columns), figsize=size, layout="constrained", squeeze=False, sharex=True, sharey=True)
    x_axis, y_axis, styles = one.axis("x"), one.axis("y"), line_styles(one)
    for axes in grid.flat:
        axes.set_visible(False)
    for row, column, series, title in panels:
        axes = grid[row, column]
        axes.set_visible(True)
        draw_panel(axes, one, series, x_axis, y_axis, styles)
        if title:
            axes.set_title(title, fontsize=11)
        axes.tick_params(labelbottom=True, labelleft=True, labelsize=9)
    for row, name in enumerate(rows):
        if name is not None:
            grid[row, 0].set_ylabel(name, fontsize=11, fontweight="bold")
    for column, name in enumerate(columns):
        if name is not None:
            grid[0, column].set_title(name, fontsize=11)
    figure.supylabel(one.facts["y_name"], fontsize=12)
    figure.suptitle(one.title[:1].upper() + one.title[1:], fontsize=14, fontweight="bold", x=0.01, ha="left")
    legend(figure, one, styles)
    # The axis' name in a strip of its own above the legend's, which the layout does not know of.
    low = figure.get_layout_engine().get()["rect"][1]
    strip = 0.4 / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, low + strip, 1, 1 - low - strip))
    figure.text(0.5, low + 0.25 * strip, one.facts["x_name"], ha="center", fontsize=12)
    save_figure(figure, stem + ".png")
    save_figure(figure, stem + ".svg")
    plt.close(figure)


def share(part, whole):
    return f"{part} of {whole} ({100 * part / whole:.0f} %)" if whole else "none"


def confusion_row(name, counts, seconds):
    return [name, counts["points"], counts["working"], counts["degraded"], counts["failures"], share(counts["predicted"], counts["failures"]),
            share(counts["false_alarms"], counts["alarms"]), f"{seconds:.1f}"]


def map_charts(one):
    """A chart for each series of a map; lines of theory are dashed."""
    out, (low_x, high_x, _, log_x), (low_y, high_y, _, log_y) = [], one.axis("x"), one.axis("y")
    markers = {"works": "circle", "degrades": "rect", "fails": "crossRot"}
    colours = {"works": "green", "degrades": "orange", "fails": "vermilion"}
    for name in one.series or [""]:
        points = [p for p in one.points if p["series"] == name and math.isfinite(p["x"]) and math.isfinite(p["y"])]
        groups = [(words, verdict, [p for p in points if p["verdict"] == verdict], 4) for verdict, (_, _, _, words) in VERDICTS.items()]
        groups += [("failed without having been predicted", "silent", [p for p in points if p["verdict"] == "fails" and not p["predicted_failure"]], 7),
                   ("predicted to fail, but works", "false", [p for p in points if p["verdict"] == "works" and p["predicted_failure"]], 7)]
        series = [{"label": words, "colour": colours.get(verdict, "ink" if verdict == "silent" else "blue"), "marker": markers.get(verdict, "triangle" if verdict == "silent" else "rectRot"), "radius": radius,
                   "points": True, "x": [short(p["x"]) for p in chosen], "y": [short(p["y"]) for p in chosen], "notes": [p["why"] or verdict for p in chosen]} for words, verdict, chosen, radius in groups if chosen]
        for i, ((owner, label, is_theory), line) in enumerate(one.lines.items()):
            if owner in (name, ""):
                x, y = zip(*line)
                series.append({"label": label + ("" if is_theory or "measured" in label else " (measured)"), "colour": ["ink", "blue", "purple", "grey"][i % 4], "dash": [6, 3] if is_theory else [],
                               "width": 2 if is_theory else 1.4, "x": [short(v) for v in x], "y": [short(v) for v in y]})
        title = one.title[:1].upper() + one.title[1:]
        out.append({"title": name or title, "heading": title, "series": series,
                    "x": {"title": one.facts["x_name"], "log": log_x, "min": short(float(low_x)), "max": short(float(high_x))},
                    "y": {"title": one.facts["y_name"], "log": log_y, "min": short(float(low_y)), "max": short(float(high_y))}, "size": "mid"})
    return out


def failures(one, most=6):
    """The failures that nothing announced: what is still to be done."""
    silent = [p for p in one.points if p["verdict"] == "fails" and not p["predicted_failure"]]
    out = [f"{p['series']} at ({p['x']:.3g}, {p['y']:.3g}): {p['why']}" for p in silent[:most]]
    return out + ([f"… and {len(silent) - most} more in {one.name}.csv"] if len(silent) > most else [])


def stability_report(folder, title):
    facts = read_json(folder, "stability.json")
    if facts is None:
        raise SystemExit(f"report.py: {folder}: no stability.json there")
    maps = [StabilityMap(folder, m) for m in facts["maps"]]
    if CAN_DRAW:
        for one in maps:
            if one.points:
                draw_map(one, os.path.join(folder, one.name))
    rows = [confusion_row(m["title"], m["confusion"], m["seconds"]) for m in facts["maps"]]
    if len(rows) > 1:
        rows.append(confusion_row("all maps", facts["sum"], facts["seconds"]))
    shown = [{"name": one.name, "title": one.title[:1].upper() + one.title[1:], "claim": one.facts["claim"], "failures": failures(one), "still": picture(folder, one.name + ".png"),
              "charts": map_charts(one) if CAN_DRAW and one.points else []} for one in maps]
    write_page(os.path.join(folder, "stability.html"), "stability.html", title=title or "Where the methods work, and where they fail", subtitle="maps of kilotouch stability", stopped=facts.get("stopped"),
               rows=rows, maps=shown, command=facts["command"])
