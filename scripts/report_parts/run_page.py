"""report.html of a run, and its pictures."""
import json
import os

from report_parts.charts import MODES, curve_chart, histogram_chart, mode_bands
from report_parts.drawing import CAN_DRAW, np
from report_parts.pages import picture, write_page
from report_parts.player import player_data
from report_parts.results import Run
from report_parts.surface_picture import draw_mesh
from report_parts.trace_pictures import draw_force_figure, indentation, refresh_times, size_of_force
from report_parts.words import FORCE, LENGTH, figures, look_up, noticed, other_numbers, percent, summary_groups, with_unit, written


def force_charts(run):
    """Forces, and how far the surface is pushed in, over one time."""
    trace = run.trace
    t = trace["t"]
    bands = {"bands": mode_bands(t, trace["mode"]), "group": "time",
             "modes": {word: words for word, words in MODES.items() if (trace["mode"] == word).any()}}
    curves = [("normal force", "normal", trace["f_n"], {"width": 2}), ("tangential force", "tangential", trace["f_t"], {"width": 2, "dash": [2, 2]})]
    if run.second_trace is None or run.reference is not None:
        curves.append(("whole force, as felt", "force", size_of_force(trace), {"width": 1}))
    friction = run.friction()
    for mu, dash in {mu: [6, 3] if i else [5, 3, 1, 3] for i, mu in enumerate(sorted(set(friction or ())))}.items():
        if mu > 0:
            curves.append((f"µ × normal force, µ = {mu:g}", "limit", mu * trace["f_n"], {"width": 1, "dash": dash}))
    more = []
    for other, columns in ((run.second_trace, (("second tool: normal", "normal", "f_n"), ("second tool: tangential", "tangential", "f_t"))),):
        if other is not None and len(other["t"]) == len(t):
            more += [(label, colour, other[column], {"width": 1.3, "dash": [6, 3]}) for label, colour, column in columns]
    if run.reference is not None and len(run.reference["t"]) >= len(t):
        more.append(("reference: whole force", "force", size_of_force(run.reference)[:len(t)], {"width": 2.5, "dash": [8, 4]}))
    refreshes = refresh_times(trace)
    every = (f" A new local model came mostly every {figures(1e3 * float(np.median(np.diff(refreshes))))} ms." if len(refreshes) > 1 else "")
    title = "Force on the tool" if run.second_trace is None else "Force on both tools"
    out = [curve_chart(title, t, curves + more, "force [N]", note="The background tells the contact's mode." + every, unit="N", **bands)]
    depth = indentation(trace)
    if depth is not None:
        curves = [("pushed in", "ink", 1e3 * depth, {"width": 2})]
        second = indentation(run.second_trace) if run.second_trace is not None else None
        if second is not None and len(second) == len(t):
            curves.append(("second tool: pushed in", "ink", 1e3 * second, {"dash": [6, 3]}))
        out.append(curve_chart("Indentation along the contact normal", t, curves, "[mm]", size="low", unit="mm", **bands,
                               note="How far the surface at the contact is from where it was before it was touched, a body's swing included."))
    return out


def step_chart(run):
    times = run.trace["step_us"]
    times = times[np.isfinite(times) & (times > 0)]
    if not len(times):
        return None
    tick = 1e6 * float(np.median(np.diff(run.trace["t"])))
    share = [float(np.percentile(times, p, method="inverted_cdf")) for p in (50, 99, 99.9)]
    marks = [{"x": value, "colour": colour, "words": f"{words} {figures(value)} µs"}
             for words, value, colour in zip(("median", "99 %", "99.9 %"), share, ("ink", "grey", "brown"))]
    marks.append({"x": tick, "colour": "purple", "dash": [5, 4], "words": "one tick"})
    out = histogram_chart("Processor time of a haptic tick", times.tolist(), "[µs]", "ticks", bins=80, marks=marks)
    out["note"] += f"; slowest {figures(float(times.max()))} µs. All should lie left of the dashed line."
    if "x" in out:
        out["x"]["max"] = max(out["x"]["max"], 1.3 * tick)
        out["y"].update(log=True, min=0.7)
    return out


CARDS = [("force.mean_n", "mean normal force", FORCE), ("step_us.p99", "99 of 100 ticks are below", with_unit("µs")),
         ("force.buzz", "buzz above 100 Hz", percent), ("local.expected_force_error", "force error of the local model alone", percent),
         ("reference.force_error", "force error against the reference", percent), ("penetration_max_m", "deepest penetration", LENGTH)]


def cards(run):
    """The numbers that a reader looks for first."""
    out = []
    for key, name, write in CARDS:
        value = look_up(run.summary, key)
        if value is not None:
            level, _ = noticed(run.summary, key)
            out.append({"value": written(value, write), "name": name, "noticed": level})
    depth = indentation(run.trace)
    if depth is not None and np.isfinite(depth).any():
        out.append({"value": LENGTH(float(np.nanmax(depth))), "name": "deepest indentation along the contact normal", "noticed": ""})
    return out


def real_time(summary):
    """Whether it holds, because of what, and the setting that cures it. None in a folder that does not say."""
    why = look_up(summary, "real_time.why") or look_up(summary, "real_time.told")
    if not why:
        return None
    keeps = str(look_up(summary, "real_time.keeps"))
    return {"word": {"just_about": "just about"}.get(keeps, keeps), "level": {"yes": "", "no": "no"}.get(keeps, "perhaps"), "why": str(why),
            "cure": look_up(summary, "real_time.cure")}


def report(folder, title, vectors=None):
    run = Run(folder)
    if run.is_empty:
        raise SystemExit(f"report.py: {folder}: no trace.csv, summary.json or view.json there")
    where = lambda name: os.path.join(folder, name)
    charts, steps = [], None
    if CAN_DRAW:
        for extension in ("png", vectors) if vectors else ("png",):
            draw_mesh(run, where("mesh." + extension))
            if run.trace is not None:
                draw_force_figure(run, where("force." + extension))
        if run.trace is not None:
            charts, steps = force_charts(run), step_chart(run)
    facts = [str(look_up(run.summary, key)) for key in ("model.type", "model.material") if look_up(run.summary, key)]
    facts += [f"{look_up(run.summary, key)} {unit_name}" for key, unit_name in (("model.nodes", "nodes"), ("model.triangles", "triangles"))
              if look_up(run.summary, key)]
    if run.friction():
        facts.append("µ = " + " / ".join(f"{mu:g}" for mu in sorted(set(run.friction()), reverse=True)))
    settings = run.scene or run.summary.get("settings")
    trust = run.summary.get("trust")
    write_page(where("report.html"), "run.html", title=str(title or run.scene.get("title") or run.summary.get("title") or run.summary.get("scene") or run.name),
               subtitle=", ".join(facts), real_time=real_time(run.summary), trust=trust if isinstance(trust, dict) else None,
               notes=run.summary.get("notes" if "trust" in run.summary else "warnings") or [], cards=cards(run), charts=charts, steps=steps,
               stills={name: picture(folder, name + ".png") for name in ("force", "mesh")} if CAN_DRAW else {},
               player=player_data(run), groups=summary_groups([run]), others=other_numbers(run.summary), command=run.summary.get("command"),
               marks=[(name, run.summary[key]) for key, name in (("seed", "seed"), ("hash", "state hash")) if key in run.summary],
               settings=json.dumps(settings, indent=2, ensure_ascii=False) if settings else "")
