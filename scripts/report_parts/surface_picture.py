"""mesh.png: the surface, where the tool went and what it felt."""
import math

from report_parts.drawing import matplotlib, np, plt
from report_parts.palette import PALETTE, TOOL
from report_parts.whole_file import save_figure


def sphere_triangles(radius, around=20, rings=12):
    """(k, 3, 3) corners of a ball around the origin."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, around + 1), indexing="ij")
    p = radius * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], axis=2).reshape(-1, 3, 3), np.stack([a, c, d], axis=2).reshape(-1, 3, 3)])


def rotation(vector):
    """(3, 3) of a rotation vector [rad]."""
    vector = np.array(vector, float)
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def tool_triangles(tool, t):
    """(k, 3, 3) corners of the tool's surface around its reference point, as it is turned at time t."""
    corners = np.array(tool.get("corners") or [], float)
    if tool["shape"] == "mesh":
        triangles = corners[np.array(tool["triangles"], int)]
    else:
        triangles = sphere_triangles(tool["radius"])
        if tool["shape"] == "capsule":  # the halves of a ball, pulled apart
            triangles = triangles + np.where(triangles.mean(axis=1)[:, None, 2:] < 0, corners[0], corners[1])
            half = np.linspace(0, 2 * np.pi, 21)
            circle = tool["radius"] * np.stack([np.cos(half), np.sin(half), 0 * half], axis=-1)
            a, b = circle[:-1], circle[1:]
            ring = np.concatenate([np.stack([a + corners[0], b + corners[0], b + corners[1]], axis=1),
                                   np.stack([a + corners[0], b + corners[1], a + corners[1]], axis=1)])
            triangles = np.concatenate([triangles, ring])
    turn = rotation(t * np.array(tool.get("spin") or [0, 0, 0])) @ rotation(tool.get("turn") or [0, 0, 0])
    return triangles @ turn.T


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
            up = unit(path[0] - np.mean(np.array(frames[0]["x"] if frames else view["rest"], float), axis=0))
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


def joined_to(triangles, chosen, start):
    """Of the chosen triangles (mask), those that hang together by nodes with number `start`: a close-up shows no loose pieces of
    what is far along the surface and just within the box."""
    label = np.arange(triangles.max() + 1)
    parts = triangles[chosen]
    while True:
        least = label[parts].min(axis=1)
        before = label.copy()
        for corner in range(3):
            np.minimum.at(label, parts[:, corner], least)
        if (label == before).all():
            return chosen & (label[triangles] == label[triangles[start, 0]]).all(axis=1)


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
    if seen.any() and not (seen == (normals @ camera.direction > 0)).all():  # a close-up
        away = np.linalg.norm(corners.mean(axis=1) - np.array(frame["tool"], float), axis=1)
        seen = joined_to(triangles, seen, int(np.argmin(np.where(seen, away, np.inf))))
    corners = corners[seen]
    faces = shaded(corners, colour_of(moved[triangles[seen]].mean(axis=1)), camera.light)
    edges = 0.88 * faces
    whole = (corners >= window[0]).all(axis=(1, 2)) & (corners <= window[1]).all(axis=(1, 2))
    polygons = [corner if inside else clipped(corner, window) for corner, inside in zip(corners, whole)]
    tools = [name for name in ("tool", "second_tool") if view.get(name) and name in frame]
    is_point = {name: view[name].get("shape") == "point" or not (view[name].get("radius") or 0.0) > 0 for name in tools}
    for name in tools:
        if is_point[name]:
            continue
        ball = np.array(frame[name], float) + tool_triangles(view[name], frame["t"])
        ball_faces = shaded(ball, matplotlib.colors.to_rgba("#F4F4F4"), camera.light)
        ball_seen = np.cross(ball[:, 1] - ball[:, 0], ball[:, 2] - ball[:, 0]) @ camera.direction > 0
        polygons += list(ball[ball_seen])
        faces, edges = np.concatenate([faces, ball_faces[ball_seen]]), np.concatenate([edges, ball_faces[ball_seen]])
    edges[:, 3] = 1.0
    faces[:, 3] = 1.0
    keep = [i for i, polygon in enumerate(polygons) if len(polygon) > 2]
    axes.add_collection3d(Poly3DCollection([1e3 * polygons[i] for i in keep], facecolors=faces[keep], edgecolors=edges[keep],
                                           linewidths=0.25))
    for name in tools:
        path = 1e3 * np.array(view.get("path" if name == "tool" else "second_path") or [frame[name]], float)
        inside = ((path >= 1e3 * window[0]) & (path <= 1e3 * window[1])).all(axis=1)
        path = np.where(inside[:, None], path, np.nan)
        axes.plot(*path.T, color=TOOL, lw=1.4, ls="--", zorder=10)
        if is_point[name]:
            axes.plot(*(1e3 * np.array(frame[name], float)[:, None]), color=TOOL, marker="o", ms=6, mec="white", zorder=11)
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
    scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(0, max(1e3 * max(shifts), 1e-6)),
                                          matplotlib.colors.LinearSegmentedColormap.from_list("displacement", PALETTE["displacement"]))
    camera = Camera(view, run.trace)
    radius = view["tool"].get("radius") or 0.0
    radius += max((np.linalg.norm(c) for c in view["tool"].get("corners") or []), default=0.0)
    everything = np.concatenate([rest] + [np.array(frame["x"], float) for frame in frames])
    tools = np.array([frame["tool"] for frame in frames], float)
    seconds = np.array([frame.get("second_tool", frame["tool"]) for frame in frames], float)
    both = np.concatenate([tools, seconds])
    whole = (np.minimum(everything.min(0), (both - radius).min(0)), np.maximum(everything.max(0), (both + radius).max(0)))
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
    columns = 2 if small == 4 else 1  # no hole in the grid
    rows = math.ceil(small / columns)
    for i, frame in enumerate(frames):
        width, height = 0.40 / columns, 0.86 / rows
        box = (0.49 + (i % columns) * width, 0.02 + (rows - 1 - i // columns) * height, width, height)
        axes = figure.add_axes(box, projection="3d", computed_zorder=False)
        draw_frame(axes, view, frame, camera, scale.to_rgba, whole, zoom=1.02)
        axes.set_axis_off()
        figure.text(box[0] + 0.02, box[1] + box[3] - 0.05, f"t = {frame['t']:.2f} s", fontsize=11)
    figure.text(0.50, 0.93, "Whole object", weight="bold", fontsize=12)
    bar = figure.add_axes((0.915, 0.18, 0.016, 0.6))
    figure.colorbar(scale, cax=bar, label="displacement of the surface [mm]")
    figure.text(0.64, 0.93, "dashed: path of the tool" + ("; tool drawn to scale" if radius > 0 and view["tool"].get("shape") != "point"
                                                         else "; dot: point tool"), fontsize=10, color="#444444")
    save_figure(figure, path)
    plt.close(figure)
    return True
