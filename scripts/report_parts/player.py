"""What the player of a run's page shows: the body's surface some thirty times a second, and the tools at the ticks."""
import array
import base64
import csv
import os
import sys

from report_parts.drawing import CAN_DRAW, np
from report_parts.surface_picture import Camera

MOST_SAMPLES = 1500  # of a tool's way
MOST_BYTES = 3_700_000  # of the film and the triangles as text: with the libraries, a page of 5 MB
MODES = ["free", "stick", "slide", "frictional_slide"]


def packed(values):
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")


def read_turns(folder, name, rows):
    """(w, x, y, z) of the tool at each tick, after the start; none where there is no such record."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return None
    with open(path, newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))[1:]
    if len(lines) < rows or not lines or "qw" not in lines[0]:
        return None
    try:
        return np.array([[float(line[q]) for q in ("qw", "qx", "qy", "qz")] for line in lines[:rows]])
    except (TypeError, ValueError):
        return None


def tool_track(trace, shape, turns):
    """Samples of 15 numbers: t, place, force, contact normal, number of the mode, turn."""
    t = trace["t"]
    chosen = np.unique(np.linspace(0, len(t) - 1, min(MOST_SAMPLES, len(t))).astype(int))
    columns = lambda stem: np.column_stack([trace.get(f"{stem}_{axis}", np.zeros(len(t)))[chosen] for axis in "xyz"])
    mode = np.array([MODES.index(m) if m in MODES else 0 for m in trace["mode"][chosen]], float)
    turn = turns[chosen] if turns is not None else np.tile([1.0, 0, 0, 0], (len(chosen), 1))
    samples = np.column_stack([t[chosen], columns("tool"), columns("force"), columns("normal"), mode, turn])
    return {"shape": shape.get("shape"), "radius": shape.get("radius") or 0, "corners": shape.get("corners") or [], "triangles": shape.get("triangles") or [],
            "samples": packed(np.nan_to_num(samples)), "largest_force": float(max(np.linalg.norm(samples[:, 4:7], axis=1).max(), 1e-9))}


def player_data(run):
    """None where the folder has no film, no trace, or numpy is missing."""
    view = run.view or {}
    film = view.get("film")
    if not CAN_DRAW or run.trace is None or not film or len(film.get("x") or []) < 2 or not view.get("triangles") or not view.get("tool"):
        return None
    corners = array.array("I", (corner for triangle in view["triangles"] for corner in triangle))
    if sys.byteorder == "big":
        corners.byteswap()
    times, frames, every = film["t"], film["x"], 1
    of_triangles = len(corners) * corners.itemsize * 4 // 3
    while len(frames) > 2 and of_triangles + sum(map(len, frames)) > MOST_BYTES:
        times, frames, every = times[::2], frames[::2], 2 * every
    if of_triangles + sum(map(len, frames)) > MOST_BYTES:
        return None
    camera = Camera(view, run.trace)
    second = run.second_trace is not None and view.get("second_tool")
    tools = [tool_track(run.trace, view["tool"], read_turns(run.folder, "recording.csv", len(run.trace["t"])))]
    if second:
        tools.append(tool_track(run.second_trace, view["second_tool"], read_turns(run.folder, "recording_2.csv", len(run.second_trace["t"]))))
    rate = (len(times) - 1) / max(times[-1] - times[0], 1e-9)
    thin = f" Frames were left out to keep the page small: {rate:.3g} a second are left." if rate < 25 else ""
    return {"triangles": base64.b64encode(corners.tobytes()).decode("ascii"), "low": film["low"], "step": film["step"], "rest": film["rest"], "t": times, "x": frames,
            "tools": tools, "fixed": view.get("fixed") or [], "flat": run.setting("contact", "surface") in (None, "flat"), "direction": camera.direction.tolist(),
            "start": float(run.trace["t"][0]), "end": float(run.trace["t"][-1]), "note": thin.strip()}
