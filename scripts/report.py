#!/usr/bin/python3
"""Pictures and one self-contained HTML page from a result folder of `kilotouch`.

    report.py DIR [--title T] [--compare DIR2 ...]    DIR/force.png, step_time.png, mesh.png, report.html
    report.py --paper DIR                             DIR/paper.png, paper.html

Reads DIR/trace.csv, summary.json, view.json and scene.json; each may be missing, and what needs it is then left out.
Needs numpy and matplotlib (Debian: python3-matplotlib). Without them the page still has all numbers, and the exit
status is 3. Units are SI in the files; the pictures use mm, s, N and microseconds.
"""
import argparse
import base64
import csv
import html
import json
import math
import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # no linear algebra here, and a pool of threads costs address space
try:
    import numpy as np
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    CAN_DRAW = True
except ImportError:  # numbers are kept; only the pictures are missing
    CAN_DRAW = False

# Okabe-Ito colours: distinct for every kind of colour vision. The modes differ in lightness too, for grey prints.
BLACK, ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#D55E00", "#CC79A7")
GREY = "#777777"
MODES = {  # word in trace.csv -> (legend, shade)
    "free": ("no contact", "#FFFFFF"),
    "stick": ("stick", "#CFE6F7"),
    "slide": ("slide, no friction", "#D8D8D8"),
    "frictional_slide": ("slide with friction", "#FBE0B0"),
}
STYLE = {
    "font.size": 11, "axes.titlesize": 12, "axes.titleweight": "bold", "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "figure.dpi": 130,
    "axes.grid": False, "figure.constrained_layout.w_pad": 0.1, "figure.constrained_layout.h_pad": 0.08, "lines.linewidth": 1.5, "path.simplify": True,
}


# ---------------------------------------------------------------------------------------------------- reading

def read_json(folder, name):
    """The file's content, or None when there is no such file. A damaged file is an error that names it."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        try:
            return json.load(file)
        except ValueError as error:
            raise SystemExit(f"report.py: {path}: {error}")


def read_trace(folder):
    """Columns of trace.csv by name: floats as arrays, mode as an array of words. None without the file or a row."""
    path = os.path.join(folder, "trace.csv")
    if not CAN_DRAW or not os.path.exists(path):
        return None
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        names = [name.strip() for name in next(rows, [])]
        columns = list(zip(*(row for row in rows if len(row) == len(names))))  # a killed run may end in half a row
    if not columns or len(columns[0]) < 3:  # nothing to draw
        return None
    trace = {}
    for name, column in zip(names, columns):
        try:
            trace[name] = np.array(column) if name == "mode" else np.array(column, dtype=float)
        except ValueError:
            raise SystemExit(f"report.py: {path}: column {name} holds a word that is not a number")
    return trace


class Run:
    """Everything one result folder holds."""

    def __init__(self, folder):
        self.folder = folder
        self.trace = read_trace(folder)
        self.summary = read_json(folder, "summary.json") or {}
        self.view = read_json(folder, "view.json")
        self.scene = read_json(folder, "scene.json") or {}
        self.name = os.path.basename(os.path.abspath(folder))

    @property
    def is_empty(self):
        return self.trace is None and not self.summary and self.view is None

    def setting(self, group, key):
        """A setting from scene.json, else from summary.json."""
        for source in (self.scene, self.summary.get("settings"), self.summary):
            if isinstance(source, dict) and isinstance(source.get(group), dict) and key in source[group]:
                return source[group][key]
        return None

    def friction(self):
        """(static, kinetic) coefficients, or None."""
        mu = self.setting("contact", "mu")
        pair = (self.setting("contact", "mu_static"), self.setting("contact", "mu_kinetic"))
        return pair if None not in pair else (mu, mu) if mu is not None else None


# ---------------------------------------------------------------------------------------------------- pictures of a trace

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


def draw_forces(axes, trace, friction=None, modes=True, normal=BLUE, labels=True):
    """Normal force solid, tangential dotted as in the paper, and the friction limit. Returns the legend's handles."""
    t = trace["t"]
    handles = axes.plot(t, trace["f_n"], color=normal, label="normal force $f_n$", zorder=3)
    handles += axes.plot(t, trace["f_t"], color=VERMILION, ls=(0, (1, 0.8)), lw=1.9, label="tangential force $f_t$", zorder=4)
    if friction:
        names = {friction[0]: r"$\mu f_n$"} if friction[0] == friction[1] else {
            friction[0]: r"$\mu_s f_n$", friction[1]: r"$\mu_k f_n$"}
        for mu, name in names.items():
            if mu != 1:  # with mu = 1 the limit is the normal force itself
                handles += axes.plot(t, mu * trace["f_n"], color=GREY, lw=1.0, ls="--" if mu == friction[0] else "-.", label=f"{name}, $\\mu$ = {mu:g}"
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


def tool_depth(trace):
    """How far the tool has gone since first contact, along the way it came [m]; None without a contact."""
    tool = np.column_stack([trace["tool_x"], trace["tool_y"], trace["tool_z"]])
    touching = np.flatnonzero(trace["mode"] != "free")
    if not len(touching):
        return None
    first = touching[0]
    way = tool[first] - tool[max(0, first - 20)]
    force = np.array([trace[f"force_{axis}"][touching].sum() for axis in "xyz"])
    if np.linalg.norm(way) < 1e-12 or way @ force > 0:  # starts in contact, or glides in: against the force then
        way = -force
    length = np.linalg.norm(way)
    return (tool - tool[first]) @ way / length if length > 0 else None


def draw_force_figure(run, path):
    trace = run.trace
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6.4), sharex=True, gridspec_kw={"height_ratios": [2.4, 1]},
                                         layout="constrained")
    handles = draw_forces(top, trace, run.friction())
    refreshes = refresh_times(trace)
    if len(refreshes) > 1:
        every = f"new local model every {figures(1e3 * float(np.median(np.diff(refreshes))))} ms"
    if len(refreshes) > 200:  # ticks would be one grey band
        top.text(1.0, 1.02, every, transform=top.transAxes, ha="right", fontsize=10, color="#444444")
    elif len(refreshes) > 1:
        handles += top.plot(refreshes, np.full(len(refreshes), 0.012), ls="none", marker="|", ms=7, mew=0.8, color=PURPLE,
                            alpha=0.7, transform=top.get_xaxis_transform(), label=every, zorder=5)
    top.set_title("Force over time")
    legend_below(figure, handles, columns=4)

    depth = tool_depth(trace)
    gap = 1e3 * trace["gap"]
    if depth is not None:
        bottom.plot(trace["t"], 1e3 * depth, color=BLACK, label="tool depth, from first contact", zorder=3)
    bottom.plot(trace["t"], np.where(np.isfinite(gap), gap, np.nan), color=GREEN, lw=1.2, ls="--", label="gap to the surface",
                zorder=3)
    bottom.set_ylabel("distance [mm]")
    bottom.set_xlabel("time [s]")
    low, high = bottom.get_ylim()
    bottom.set_ylim(low, high + 0.45 * (high - low))  # room for the legend
    mode_strip(bottom, trace)
    bottom.legend(loc="upper left", ncol=2, fontsize=10)
    figure.savefig(path)
    plt.close(figure)


def draw_step_times(run, path):
    times = run.trace["step_us"]
    times = times[np.isfinite(times) & (times > 0)]
    if not len(times):
        return False
    tick = 1e6 * float(np.median(np.diff(run.trace["t"]))) if len(run.trace["t"]) > 1 else 1000.0
    figure, axes = plt.subplots(figsize=(10, 4.4), layout="constrained")
    low, high = times.min() / 1.2, max(times.max(), tick) * 1.35
    bins = np.geomspace(low, high, 110)
    counts, _, _ = axes.hist(times, bins=bins, color=SKY, edgecolor="white", linewidth=0.3)
    axes.set(xscale="log", yscale="log", xlim=(low, high), ylim=(0.7, counts.max() * 2.2), ylabel="ticks")
    axes.set_xlabel("time of a haptic tick [µs]")
    axes.xaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda x, _: f"{x:g}"))
    axes.yaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda y, _: f"{y:g}"))
    marks = [("median", np.median(times), BLACK, "-"), ("99 %", np.percentile(times, 99), BLUE, "--"),
             ("99.9 %", np.percentile(times, 99.9), VERMILION, "-."), ("limit, one tick", tick, PURPLE, ":")]
    for name, value, colour, style in marks:
        axes.axvline(value, color=colour, ls=style, lw=1.6, label=f"{name}: {figures(value)} µs")
    axes.set_title(f"Processor time of each of {len(times)} ticks (slowest {figures(times.max())} µs)")
    legend_below(figure, axes.lines, columns=4)
    figure.savefig(path)
    plt.close(figure)
    return True


def draw_comparison(runs, path):
    """Normal and tangential forces of several runs over each other."""
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6), sharex=True, layout="constrained")
    styles = [(BLUE, "-"), (VERMILION, "--"), (GREEN, "-."), (PURPLE, ":"), (BLACK, (0, (5, 1, 1, 1)))]
    for i, run in enumerate(runs):
        colour, dash = styles[i % len(styles)]
        top.plot(run.trace["t"], run.trace["f_n"], color=colour, ls=dash, lw=1.4, label=run.name)
        bottom.plot(run.trace["t"], run.trace["f_t"], color=colour, ls=dash, lw=1.4)
    top.set_ylabel("normal force [N]")
    bottom.set_ylabel("tangential force [N]")
    bottom.set_xlabel("time [s]")
    bottom.set_xlim(min(run.trace['t'][0] for run in runs), max(run.trace['t'][-1] for run in runs))
    legend_below(figure, top.lines, columns=4)
    figure.savefig(path)
    plt.close(figure)


# ---------------------------------------------------------------------------------------------------- picture of the surface

def sphere_triangles(radius, around=20, rings=12):
    """(k, 3, 3) corners of a ball around the origin."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, around + 1), indexing="ij")
    p = radius * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], axis=2).reshape(-1, 3, 3), np.stack([a, c, d], axis=2).reshape(-1, 3, 3)])


def unit(v):
    length = np.linalg.norm(v)
    return v / length if length > 1e-15 else np.zeros(3)


class Camera:
    """Looks at the side that the tool touches, a third of the way down from above and across the drag."""

    def __init__(self, view, trace):
        frames, path = view["frames"], np.array(view.get("path") or [frame["tool"] for frame in view["frames"]], float)
        up = np.zeros(3)
        if trace is not None:  # the surface pushes the tool outwards
            touching = trace["mode"] != "free"
            up = unit(np.array([trace[f"force_{axis}"][touching].sum() for axis in "xyz"]))
            if len(path) > 1:  # friction tilts that force against the drag: take the tilt out
                along = unit(path[-1] - path[len(path) // 2])
                up = unit(up - (up @ along) * along)
        if not up.any():
            up = unit(path[0] - np.mean(np.array(frames[0]["x"], float), axis=0))
        self.up = up if up.any() else np.array([0.0, 0.0, 1.0])
        drag = path[-1] - path[len(path) // 2]
        drag = unit(drag - (drag @ self.up) * self.up)
        if not drag.any():
            drag = unit(np.cross(self.up, [0.0, 1.0, 0.0] if abs(self.up[1]) < 0.9 else [1.0, 0.0, 0.0]))
        aside = np.cross(drag, self.up)  # the drag goes from left to right
        self.direction = unit(0.62 * self.up + 0.72 * aside + 0.25 * drag)
        self.light = unit(0.75 * self.up + 0.25 * self.direction - 0.55 * drag)

    def apply(self, axes):
        x, y, z = self.direction
        axes.view_init(elev=math.degrees(math.asin(z)), azim=math.degrees(math.atan2(y, x)))


def shaded(corners, colours, light):
    """Lambert: colours darken with the angle between each triangle's normal and the light."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    strength = 0.62 + 0.38 * np.clip(normals @ light, 0, 1)
    out = np.array(np.broadcast_to(colours, (len(corners), 4)), float)
    out[:, :3] *= strength[:, None]
    return out


def clipped(polygon, window):
    """The part of a polygon inside a box (Sutherland-Hodgman): a straight rim where a close-up ends."""
    for axis in range(3):
        for sign, bound in ((1, window[1][axis]), (-1, -window[0][axis])):
            out = []
            for a, b in zip(polygon, np.roll(polygon, -1, axis=0)):
                over_a, over_b = sign * a[axis] - bound, sign * b[axis] - bound
                if over_a <= 0:
                    out.append(a)
                if over_a * over_b < 0:
                    out.append(a + (b - a) * over_a / (over_a - over_b))
            polygon = np.array(out)
            if not len(out):
                return polygon
    return polygon


def draw_frame(axes, view, frame, camera, colour_of, window, zoom):
    """The surface and the tool in one collection, so that they hide each other correctly. `window`: (min, max) [m]."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
    x, rest = np.array(frame["x"], float), np.array(view["rest"], float)
    triangles = np.array(view["triangles"], int)
    moved = 1e3 * np.linalg.norm(x - rest, axis=1)
    corners = x[triangles]
    # Triangles that face away are hidden: leaving them out halves the work.
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    seen = ((normals @ camera.direction > 0) & (corners.max(axis=1) >= window[0]).all(axis=1)
            & (corners.min(axis=1) <= window[1]).all(axis=1))
    corners = corners[seen]
    faces = shaded(corners, colour_of(moved[triangles[seen]].mean(axis=1)), camera.light)
    edges = 0.88 * faces
    whole = (corners >= window[0]).all(axis=(1, 2)) & (corners <= window[1]).all(axis=(1, 2))
    polygons = [corner if inside else clipped(corner, window) for corner, inside in zip(corners, whole)]
    radius = view["tool"].get("radius") or 0.0
    is_point = view["tool"].get("shape") == "point" or radius <= 0
    if not is_point:
        ball = np.array(frame["tool"], float) + sphere_triangles(radius)
        ball_faces = shaded(ball, matplotlib.colors.to_rgba("#F4F4F4"), camera.light)
        ball_seen = np.cross(ball[:, 1] - ball[:, 0], ball[:, 2] - ball[:, 0]) @ camera.direction > 0
        polygons += list(ball[ball_seen])
        faces, edges = np.concatenate([faces, ball_faces[ball_seen]]), np.concatenate([edges, ball_faces[ball_seen]])
    edges[:, 3] = 1.0
    faces[:, 3] = 1.0
    keep = [i for i, polygon in enumerate(polygons) if len(polygon) > 2]
    axes.add_collection3d(Poly3DCollection([1e3 * polygons[i] for i in keep], facecolors=faces[keep], edgecolors=edges[keep],
                                           linewidths=0.25))
    path = 1e3 * np.array(view.get("path") or [frame["tool"]], float)
    inside = ((path >= 1e3 * window[0]) & (path <= 1e3 * window[1])).all(axis=1)
    path = np.where(inside[:, None], path, np.nan)
    axes.plot(*path.T, color=VERMILION, lw=1.4, ls="--", zorder=10)
    if is_point:
        axes.plot(*(1e3 * np.array(frame["tool"], float)[:, None]), color=VERMILION, marker="o", ms=6, mec="white", zorder=11)
    camera.apply(axes)
    for axis, low, high in zip("xyz", 1e3 * window[0], 1e3 * window[1]):
        getattr(axes, f"set_{axis}lim")(low, high)
    axes.set_proj_type("ortho")
    axes.set_box_aspect(1e3 * (window[1] - window[0]), zoom=zoom)


def few_ticks(axes, window):
    """Few ticks, so that labels never touch."""
    span = 1e3 * (window[1] - window[0])
    for name, axis, extent in zip("xyz", (axes.xaxis, axes.yaxis, axes.zaxis), span):
        axis.set_major_locator(matplotlib.ticker.MaxNLocator(2 if extent < 0.45 * span.max() else 4))
        axis.set_tick_params(labelsize=9, pad=1)
        axis.pane.set_visible(False)
        getattr(axes, f"set_{name}label")(f"{name} [mm]", fontsize=10, labelpad=4)
    axes.grid(False)


def height_in_view(x, tool, radius, window, axis, up):
    """(low, high) along an axis [m] of the touched side of the surface inside the window, and of the tool."""
    others = [a for a in range(3) if a != axis]
    inside = ((x[:, others] >= window[0][others]) & (x[:, others] <= window[1][others])).all(axis=1)
    heights = x[inside, axis] * np.sign(up[axis])
    low = min(np.percentile(heights, 50) if len(heights) else tool[axis], tool[axis] * np.sign(up[axis]) - 3 * radius)
    high = max(heights.max() if len(heights) else low, tool[axis] * np.sign(up[axis]) + radius)
    low = min(low, high - 0.25 * (window[1] - window[0])[others].max())
    return sorted((low * np.sign(up[axis]), high * np.sign(up[axis])))


def draw_mesh(run, path):
    view = dict(run.view or {})
    if not view.get("path") and run.trace is not None:
        view["path"] = np.column_stack([run.trace[f"tool_{axis}"] for axis in "xyz"])[:: max(1, len(run.trace["t"]) // 200)].tolist()
    if not view.get("rest") or not view.get("tool") or not view.get("frames") or not view.get("triangles"):
        return False
    frames = view["frames"][:4]
    rest = np.array(view["rest"], float)
    shifts = [np.linalg.norm(np.array(frame["x"], float) - rest, axis=1).max() for frame in frames]
    worst = int(np.argmax(shifts))
    scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(0, max(1e3 * max(shifts), 1e-6)), "YlGnBu")
    camera = Camera(view, run.trace)
    radius = view["tool"].get("radius") or 0.0
    everything = np.concatenate([rest] + [np.array(frame["x"], float) for frame in frames])
    tools = np.array([frame["tool"] for frame in frames], float)
    whole = (np.minimum(everything.min(0), (tools - radius).min(0)), np.maximum(everything.max(0), (tools + radius).max(0)))
    # Close-up: a cube around the tool, large enough to show the whole dent.
    reach = max(4.5 * radius, 6 * shifts[worst], 0.12 * (whole[1] - whole[0]).max())
    near = np.array([np.maximum(whole[0], tools[worst] - reach), np.minimum(whole[1], tools[worst] + reach)])
    flat_axis = int(np.argmax(np.abs(camera.up)))  # along it the box is as high as the part in view
    near[:, flat_axis] = height_in_view(np.array(frames[worst]["x"], float), tools[worst], radius, near, flat_axis, camera.up)

    figure = plt.figure(figsize=(12, 5.4))
    small = len(frames)
    close = figure.add_axes((-0.04, -0.04, 0.54, 1.0), projection="3d", computed_zorder=False)
    draw_frame(close, view, frames[worst], camera, scale.to_rgba, near, zoom=0.9)
    few_ticks(close, near)
    figure.text(0.03, 0.93, f"Close-up at t = {frames[worst]['t']:.2f} s", weight="bold", fontsize=12)
    columns = 1 if small == 1 else 2
    rows = math.ceil(small / columns)
    for i, frame in enumerate(frames):
        width, height = 0.40 / columns, 0.86 / rows
        box = (0.49 + (i % columns) * width, 0.02 + (rows - 1 - i // columns) * height, width, height)
        axes = figure.add_axes(box, projection="3d", computed_zorder=False)
        draw_frame(axes, view, frame, camera, scale.to_rgba, whole, zoom=1.02)
        axes.set_axis_off()
        figure.text(box[0] + 0.02, box[1] + box[3] - 0.035, f"t = {frame['t']:.2f} s", fontsize=11)
    figure.text(0.50, 0.93, "Whole object", weight="bold", fontsize=12)
    bar = figure.add_axes((0.915, 0.18, 0.016, 0.6))
    figure.colorbar(scale, cax=bar, label="displacement of the surface [mm]")
    figure.text(0.64, 0.93, "dashed: path of the tool" + ("; tool drawn to scale" if radius > 0 and view["tool"].get("shape") != "point"
                                                         else "; dot: point tool"), fontsize=10, color="#444444")
    figure.savefig(path)
    plt.close(figure)
    return True


# ---------------------------------------------------------------------------------------------------- numbers in words

def figures(value, digits=3):
    """Three significant figures without an exponent where a person would not write one."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if not isinstance(value, float):
        return str(value)
    if not math.isfinite(value):
        return str(value)
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))  # 0.0479, 5.23, 120
        return f"{value:.{decimals}f}"
    return f"{value:.{digits - 1}e}".replace("e-0", "e-").replace("e+0", "e")


def percent(value):
    return figures(100.0 * value) + " %"


def with_unit(unit_name, factor=1.0):
    return lambda value: f"{figures(factor * value if factor != 1.0 else value)} {unit_name}".strip()


PLAIN = with_unit("")
ROWS = [  # (group, [(key in summary.json, name, how to write it, what it means)])
    ("Force on the tool", [
        ("force.mean_n", "normal force, mean", with_unit("N"), "pushes the tool out of the surface; over the steady drag"),
        ("force.max_n", "normal force, largest", with_unit("N"), ""),
        ("force.mean_t", "tangential force, mean", with_unit("N"), "resists the drag"),
        ("force.max_t", "tangential force, largest", with_unit("N"), ""),
        ("force.max_t_over_mu_n", "use of the friction cone", PLAIN, "largest tangential force over µ × normal force; Coulomb friction allows at most 1"),
        ("force.buzz", "buzz", percent, "vibration above 100 Hz over the mean force; people notice forces that differ by 7–10 %"),
        ("force.crossing_jump", "jump at a mesh line", percent, "largest change in one tick when the contact enters another triangle, over the mean force"),
        ("force.refresh_jump", "jump at a new local model", percent, "the same when the slow side delivers a new model"),
    ]),
    ("Contact", [
        ("ticks.total", "ticks", PLAIN, "steps of the fast side"),
        ("ticks.free", "… without contact", PLAIN, ""),
        ("ticks.stick", "… sticking", PLAIN, "the surface follows the tool"),
        ("ticks.slide", "… sliding, no friction", PLAIN, ""),
        ("ticks.frictional_slide", "… sliding with friction", PLAIN, ""),
        ("crossings", "triangles entered", PLAIN, "times the contact went from one triangle to the next"),
        ("lost_contacts", "contacts lost", PLAIN, "the tool passed an edge and no triangle was found there; should be 0"),
        ("missed_impacts", "impacts missed", PLAIN, "found by the exhaustive check only; must be 0"),
        ("penetration_max_m", "deepest penetration", with_unit("µm", 1e6), "of the tool below the deformed surface at the end of a tick"),
        ("energy_min_j", "least energy taken from the hand", with_unit("µJ", 1e6), "negative: the device was given energy"),
    ]),
    ("Time", [
        ("step_us.p50", "haptic tick, median", with_unit("µs"), "processor time; at 1 kHz there are 1000 µs"),
        ("step_us.p99", "… 99 of 100 are below", with_unit("µs"), ""),
        ("step_us.p999", "… 999 of 1000 are below", with_unit("µs"), ""),
        ("step_us.max", "… slowest", with_unit("µs"), "a shared machine may stall a single tick"),
        ("deadline_misses", "ticks over their time", PLAIN, ""),
        ("allocations_per_tick", "memory allocations per tick", PLAIN, "must be 0: an allocation can wait for the system"),
        ("global_ms.p50", "global step, median", with_unit("ms"), "of the whole object"),
        ("global_ms.p99", "… 99 of 100 are below", with_unit("ms"), ""),
        ("global_ms.max", "… slowest", with_unit("ms"), ""),
        ("refresh_ms.p50", "new local model, median", with_unit("ms"), "linearize and reduce"),
        ("refresh_ms.p99", "… 99 of 100 are below", with_unit("ms"), ""),
    ]),
    ("Models", [
        ("model.type", "global model", PLAIN, ""),
        ("model.material", "material", PLAIN, ""),
        ("model.nodes", "nodes", PLAIN, ""),
        ("model.tets", "tetrahedra", PLAIN, ""),
        ("model.springs", "springs", PLAIN, ""),
        ("model.triangles", "surface triangles", PLAIN, ""),
        ("local.reducer", "local model", PLAIN, "how the fast side's model is cut out of the global one"),
        ("local.dof", "unknowns of the local model", PLAIN, ""),
        ("local.patch_vertices", "surface nodes of the local model", PLAIN, ""),
        ("local.certified_error", "certified error of the local model", percent, "against the full model, 0–500 Hz; people notice 7–10 %"),
        ("local.reason", "why this local model", PLAIN, ""),
    ]),
    ("Against the reference", [
        ("reference.force_error", "force error", percent, "over the whole run, against the full model with a fine step"),
        ("reference.jnd_fraction", "time with a noticeable error", percent, "share of the run in which the force is off by more than 10 %"),
    ]),
]
HEAD_KEYS = ("scene", "seed", "hash", "warnings", "command", "settings", "contact")


def look_up(data, dotted):
    for part in dotted.split("."):
        if not isinstance(data, dict) or part not in data:
            return None
        data = data[part]
    return data


def leaves(data, prefix=""):
    """(dotted key, value) of all that is not a group."""
    for key, value in data.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from leaves(value, name + ".")
        else:
            yield name, value


def written(value, write):
    """A cell: empty for what was not measured; a word stays a word where a number was due."""
    if value is None or value == "":
        return "–"
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return html.escape(write(value) if is_number else figures(value))


def summary_table(runs):
    """One row a quantity, one column a run, with what it means. Keys that have no words yet come last, as they are."""
    many = len(runs) > 1
    head = "".join(f"<th class=number>{html.escape(run.name)}</th>" for run in runs) if many else "<th class=number>value</th>"
    out, known = [], set(HEAD_KEYS)
    for group, rows in ROWS:
        body = []
        for key, name, write, meaning in rows:
            known.add(key)
            values = [look_up(run.summary, key) for run in runs]
            if all(value in (None, "") for value in values):
                continue
            cells = "".join(f"<td class={'long' if isinstance(v, str) and len(v) > 16 else 'number'}>{written(v, write)}</td>" for v in values)
            body.append(f"<tr><td>{html.escape(name)}</td>{cells}<td class=note>{html.escape(meaning)}</td></tr>")
        if body:
            out.append(f"<h3>{group}</h3><table class=numbers><tr><th>quantity</th>{head}<th>meaning</th></tr>{''.join(body)}</table>")
    rest = [(key, value) for key, value in leaves(runs[0].summary)
            if key not in known and key.split(".")[0] not in HEAD_KEYS and not isinstance(value, list)]
    if rest:
        rows = "".join(f"<tr><td><code>{html.escape(key)}</code></td><td class=number>{written(value, PLAIN)}</td></tr>" for key, value in rest)
        out.append(f"<h3>Other numbers of summary.json</h3><table><tr><th>key</th><th class=number>value</th></tr>{rows}</table>")
    return "".join(out)


# ---------------------------------------------------------------------------------------------------- pages

CSS = """
body { font: 16px/1.5 system-ui, 'DejaVu Sans', sans-serif; color: #1a1a1a; max-width: 1080px; margin: 2em auto; padding: 0 1.2em; }
h1 { font-size: 1.7em; margin-bottom: 0.1em; } h2 { margin-top: 1.8em; border-bottom: 1px solid #ccc; } h3 { margin: 1.3em 0 0.3em; }
.sub { color: #555; margin-top: 0; } img { width: 100%; height: auto; }
table { border-collapse: collapse; width: 100%; font-size: 0.92em; }
th, td { text-align: left; padding: 0.25em 0.9em 0.25em 0; border-bottom: 1px solid #e5e5e5; vertical-align: top; }
th { color: #555; font-weight: 600; } .number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; } .note { color: #555; }
.long { text-align: right; } table.numbers { table-layout: fixed; } table.numbers td { overflow-wrap: break-word; }
table.numbers th:first-child { width: 27%; } table.numbers th:last-child { width: 46%; }
.cards { display: flex; flex-wrap: wrap; gap: 0.8em; margin: 1.2em 0; }
.card { border: 1px solid #ccc; border-radius: 8px; padding: 0.6em 1em; flex: 1 1 150px; } .card b { display: block; font-size: 1.35em; }
.card span { color: #555; font-size: 0.88em; }
.warnings { background: #fff4e0; border-left: 5px solid #E69F00; padding: 0.6em 1em; margin: 1em 0; } .warnings ul { margin: 0.2em 0; padding-left: 1.2em; }
.good { color: #00694c; font-weight: 600; } .bad { color: #a83f00; font-weight: 600; }
pre { background: #f4f4f4; padding: 0.8em 1em; overflow-x: auto; font-size: 0.88em; border-radius: 6px; }
@media print { body { max-width: none; margin: 0; } h2 { break-after: avoid; } }
"""


def page(title, subtitle, body):
    return (f"<!DOCTYPE html><html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width'>"
            f"<title>{html.escape(title)}</title><style>{CSS}</style></head><body>"
            f"<h1>{html.escape(title)}</h1><p class=sub>{subtitle}</p>{body}</body></html>\n")


def picture(folder, name, meaning):
    """The picture inside the page, so that the page can be mailed alone."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return ""
    with open(path, "rb") as file:
        data = base64.b64encode(file.read()).decode("ascii")
    return f"<img alt='{html.escape(meaning, quote=True)}' src='data:image/png;base64,{data}'><p class=note>{html.escape(meaning)}</p>"


def cards(summary):
    """The five numbers that a reader looks for first."""
    chosen = [("force.mean_n", "mean normal force", with_unit("N")), ("step_us.p99", "99 of 100 ticks are below", with_unit("µs")),
              ("force.buzz", "buzz above 100 Hz", percent), ("local.certified_error", "certified error of the local model", percent),
              ("reference.force_error", "force error against the reference", percent),
              ("penetration_max_m", "deepest penetration", with_unit("µm", 1e6))]
    cells = [(look_up(summary, key), name, write) for key, name, write in chosen]
    shown = [f"<div class=card><b>{written(value, write)}</b><span>{name}</span></div>" for value, name, write in cells if value is not None]
    return f"<div class=cards>{''.join(shown[:6])}</div>" if shown else ""


def warnings_box(run):
    notes = list(run.summary.get("warnings") or [])
    if not notes:
        return ""
    return f"<div class=warnings><b>Read this first</b><ul>{''.join(f'<li>{html.escape(str(note))}</li>' for note in notes)}</ul></div>"


def reproduce(run):
    command = run.summary.get("command")
    parts = []
    if command:
        parts.append(f"<h2>Run it again</h2><pre>{html.escape(str(command))}</pre>")
    marks = [f"{name} <code>{html.escape(str(run.summary[key]))}</code>" for key, name in (("seed", "seed"), ("hash", "state hash"))
             if key in run.summary]
    if marks:
        parts.append(f"<p class=note>{', '.join(marks)}. The same command gives the same hash.</p>")
    settings = run.scene or run.summary.get("settings")
    if settings:
        parts.append(f"<h2>Settings</h2><pre>{html.escape(json.dumps(settings, indent=2, ensure_ascii=False))}</pre>")
    return "".join(parts)


def write_page(path, content):
    with open(path, "w", encoding="utf-8") as file:
        file.write(content)


def report(folder, title, others):
    run = Run(folder)
    if run.is_empty:
        raise SystemExit(f"report.py: {folder}: no trace.csv, summary.json or view.json there")
    runs = [run] + [Run(other) for other in others]
    for other in runs[1:]:
        if other.is_empty:
            raise SystemExit(f"report.py: {other.folder}: no trace.csv, summary.json or view.json there")
    where = lambda name: os.path.join(folder, name)
    drawn = []
    if CAN_DRAW:
        if run.trace is not None:
            draw_force_figure(run, where("force.png"))
            drawn.append(("force.png", "Force on the tool over time; the background tells the contact's mode, ticks at the bottom "
                          "a new local model from the slow side. Below: depth of the tool and its gap to the deformed surface."))
        if draw_mesh(run, where("mesh.png")):
            drawn.append(("mesh.png", "The deformed surface, coloured by how far each part has moved."))
        if run.trace is not None and draw_step_times(run, where("step_time.png")):
            drawn.append(("step_time.png", "Processor time of the haptic ticks, both axes logarithmic. All should lie left of the dotted line."))
        traced = [one for one in runs if one.trace is not None]
        if len(runs) > 1 and len(traced) > 1:
            draw_comparison(traced, where("compare.png"))
            drawn.insert(0, ("compare.png", "Forces of the compared runs."))
    name = title or run.scene.get("title") or run.summary.get("title") or run.summary.get("scene") or run.name
    facts = [str(look_up(run.summary, key)) for key in ("model.type", "model.material") if look_up(run.summary, key)]
    facts += [f"{look_up(run.summary, key)} {unit_name}" for key, unit_name in (("model.nodes", "nodes"), ("model.triangles", "triangles"))
              if look_up(run.summary, key)]
    if run.friction():
        facts.append("µ = " + " / ".join(f"{mu:g}" for mu in sorted(set(run.friction()), reverse=True)))
    body = warnings_box(run) + cards(run.summary)
    body += "<h2>Pictures</h2>" + "".join(picture(folder, file, meaning) for file, meaning in drawn) if drawn else ""
    body += "<h2>Numbers</h2>" + summary_table(runs) + reproduce(run)
    write_page(where("report.html"), page(str(name), html.escape(", ".join(facts)), body))


# ---------------------------------------------------------------------------------------------------- the paper's experiments

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
    figure.savefig(path)
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="DIR")
    parser.add_argument("--title")
    parser.add_argument("--compare", metavar="DIR2", nargs="+", default=[])
    parser.add_argument("--paper", action="store_true", help="DIR holds slide, stick, stick_slip, coulomb_slide and coulomb")
    arguments = parser.parse_args()
    if not os.path.isdir(arguments.folder):
        raise SystemExit(f"report.py: {arguments.folder}: no such folder")
    if CAN_DRAW:
        plt.rcParams.update(STYLE)
    if arguments.paper:
        paper_report(arguments.folder, arguments.title)
    else:
        report(arguments.folder, arguments.title, arguments.compare)
    if not CAN_DRAW:
        print("report.py: no pictures: numpy and matplotlib are missing (Debian: python3-matplotlib)", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
