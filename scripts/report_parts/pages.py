"""report.html."""
import base64
import html
import json
import os

from report_parts.drawing import CAN_DRAW
from report_parts.results import Run
from report_parts.surface_picture import draw_mesh
from report_parts.trace_pictures import draw_comparison, draw_force_figure, draw_step_times
from report_parts.whole_file import write_whole
from report_parts.words import look_up, percent, summary_table, with_unit, written

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
.answers { border: 1px solid #ccc; border-radius: 8px; padding: 0.2em 1em; margin: 1em 0; } .answers p { margin: 0.4em 0; } .answers ul { margin: 0.2em 0; padding-left: 1.2em; }
.wide { overflow-x: auto; font-size: 0.85em; } .wide td { white-space: nowrap; } .wide th.number { white-space: normal; }
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
              ("force.buzz", "buzz above 100 Hz", percent), ("local.expected_force_error", "force error to expect of the local model", percent),
              ("reference.force_error", "force error against the reference", percent),
              ("penetration_max_m", "deepest penetration", with_unit("µm", 1e6))]
    cells = [(look_up(summary, key), name, write) for key, name, write in chosen]
    shown = [f"<div class=card><b>{written(value, write)}</b><span>{name}</span></div>" for value, name, write in cells if value is not None]
    return f"<div class=cards>{''.join(shown[:6])}</div>" if shown else ""


def answers(run):
    """Real time, and whether to trust it, with what cures it. A stopped run says so before all else."""
    out = []
    told = look_up(run.summary, "real_time.told")
    if told:
        good = look_up(run.summary, "real_time.keeps") == "yes"
        out.append(f"<p><b>Real time:</b> <span class={'good' if good else 'bad'}>{html.escape(str(told))}</span></p>")
    trust = run.summary.get("trust")
    if isinstance(trust, dict):
        reasons = [(str(reason.get("what", "")), reason.get("cure")) for reason in trust.get("reasons") or []]
        word = "<span class=good>yes</span>" if trust.get("trustworthy") else "<span class=bad>no</span>"
        items = "".join(f"<li>{html.escape(what)}{f'<br><b>cure:</b> {html.escape(str(cure))}' if cure else ''}</li>" for what, cure in reasons)
        out.append(f"<p><b>Trustworthy:</b> {word}</p>" + (f"<ul>{items}</ul>" if items else ""))
    return f"<div class=answers>{''.join(out)}</div>" if out else ""


def warnings_box(run):
    """Warnings that are no reason above."""
    notes = run.summary.get("notes") if "trust" in run.summary else run.summary.get("warnings")
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
    write_whole(path, content)


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
            whose = "the tool" if run.second_trace is None else "both tools (the rest is of the first)"
            drawn.append(("force.png", f"Force on {whose} over time; the background tells the contact's mode, ticks at the bottom "
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
    body = answers(run) + warnings_box(run) + cards(run.summary)
    body += "<h2>Pictures</h2>" + "".join(picture(folder, file, meaning) for file, meaning in drawn) if drawn else ""
    body += "<h2>Numbers</h2>" + summary_table(runs) + reproduce(run)
    write_page(where("report.html"), page(str(name), html.escape(", ".join(facts)), body))
