"""report.html of `kilotouch check`: one page that needs nothing else, for one mesh or for thousands."""
import json
import math
import os

from report_parts.charts import histogram_chart
from report_parts.pages import write_page
from report_parts.thumbnail import thumbnail

STAGES = ("load", "doctor", "repair", "queries", "shots", "solid", "models", "local_models", "press", "drag", "energy")
LARGE_PICTURES = 400  # of places where something failed: more would make the page heavy


def yes_no(value):
    return "yes" if value else "no"


def stage_of(row, name):
    return next((s for s in row["stages"] if s["name"] == name), {})


def of_models(stage, part, *path):
    """Largest value of msd and fem below stage[part], or None; of models that nothing was run with, none."""
    found = []
    for model in ("msd", "fem"):
        value = (stage.get(part) or {}).get(model)
        if ((stage.get("figures") or {}).get(model) or {}).get("runs") == 0:
            continue
        for key in path:
            value = value.get(key) if isinstance(value, dict) else None
        if isinstance(value, (int, float)):
            found.append(value)
    return max(found, key=abs) if found else None


def moved(row):
    """Of the longest side."""
    size = (stage_of(row, "load").get("figures") or {}).get("longest_side") or 0
    solid = stage_of(row, "solid").get("figures") or {}
    parts = [(stage_of(row, "repair").get("figures") or {}).get("distance")]
    parts += [(solid.get(key) or {}).get("distance") for key in ("decimated", "wrap")]
    parts = [p for p in parts if isinstance(p, (int, float))]
    return sum(parts) / size if size and parts else None


def numbers_of(row):
    press, drag = stage_of(row, "press"), stage_of(row, "drag")
    return {"moved": moved(row), "error": of_models(stage_of(row, "local_models"), "figures", "worst_error"),
            "off": of_models(press, "figures", "force_error"), "buzz": of_models(drag, "figures", "buzz"),
            "step_us": of_models(drag, "times", "step_us", "p99"), "refresh_ms": of_models(drag, "times", "refresh_ms", "p50"),
            "cpu_s": row["times"].get("cpu_s")}


def figures_text(stage):
    """Figures and times on one line each, short."""
    def short(value):
        if isinstance(value, bool):
            return yes_no(value)
        if value is None:
            return "–"
        if isinstance(value, float):
            return f"{value:.3g}"
        if isinstance(value, dict):
            return "{" + ", ".join(f"{k} {short(v)}" for k, v in value.items()) + "}"
        if isinstance(value, list):
            return f"[{', '.join(short(v) for v in value[:4])}{', …' if len(value) > 4 else ''}]"
        return str(value)
    both = dict(stage.get("figures") or {}, **(stage.get("times") or {}))
    return "\n".join(f"{key}: {short(value)}" for key, value in both.items() if isinstance(value, bool) or value not in (0, [], {}))


def table_rows(report, outlines):
    many = len(report["rows"]) > 1000
    width, height = (60, 46) if many else (96, 72)
    out, large = [], 0
    for row in report["rows"]:
        outline, where = outlines.get(row["path"]), row.get("where")
        entry = {"path": row["path"], "verdict": row["verdict"], "stage": row["stage"], "why": row["why"], "triangles": row["triangles"],
                 "picture": thumbnail(outline, where, width, height), "large": "",
                 "pace": (row.get("real_time") or {}).get("keeps") or "", "told": (row.get("real_time") or {}).get("told") or ""}
        entry.update(numbers_of(row))
        if where and row["verdict"] != "pass" and large < LARGE_PICTURES:
            entry["large"] = thumbnail(outline, where, 320, 240)
            large += 1
        # What passed has its numbers in report.json; here they would make a page of thousands slow.
        detailed = not many or row["verdict"] == "fail"
        entry["stages"] = [[s["name"], s["verdict"], s["why"], s.get("where"), figures_text(s) if detailed else ""] for s in row["stages"]]
        out.append(entry)
    return out


HISTOGRAMS = (("step_us", 1, "Haptic tick", "99 of 100 ticks take less [µs]"), ("refresh_ms", 1, "New local model", "median [ms]"),
              ("cpu_s", 1, "Whole check", "CPU time [s]"), ("error", 100, "Certified error of the local model", "% of the impedance, 0–500 Hz"),
              ("off", 100, "Held force against the nonlinear body", "%"), ("buzz", 100, "Buzz while dragged", "% of the force"))


def histograms(rows):
    """A chart for each quantity that some mesh has; none without any."""
    out = []
    for key, factor, title, label in HISTOGRAMS:
        values = [abs(r[key]) * factor for r in rows if isinstance(r[key], (int, float)) and math.isfinite(r[key])]
        if values:
            marks = [{"x": 1000, "colour": "vermilion", "dash": [4, 4], "words": "one tick"}] if key == "step_us" else []
            out.append(histogram_chart(title, values, label, "meshes", marks=marks))
    return out


def cards(report):
    s, t = report["summary"], report["times"]
    shown = [(s["meshes"], "meshes"), (s["pass"], "pass"), (s["degraded"], "degraded"), (s["fail"], "fail"), (f"{s['triangles']:,}", "triangles"),
             (f"{t['cpu_s']:.0f} s", "CPU time")]
    if t.get("cpu_s_per_100000_triangles"):
        shown.append((f"{t['cpu_s_per_100000_triangles']:.0f} s", "CPU time per 10⁵ triangles"))
    return shown


def check_page(folder):
    with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
        report = json.load(file)
    try:
        with open(os.path.join(folder, "outlines.json"), encoding="utf-8") as file:
            outlines = json.load(file)
    except OSError:
        outlines = {}
    rows = table_rows(report, outlines)
    settings = ", ".join(f"{key} {yes_no(value) if isinstance(value, bool) else format(value, 'g') if isinstance(value, float) else value}" for key, value in report["settings"].items())
    total = max(1, report["summary"]["meshes"])
    failed_in = sorted((report["summary"].get("failed_in") or {}).items(), key=lambda e: -e[1])
    write_page(os.path.join(folder, "report.html"), "check.html", title="Mesh check", subtitle=f"kilotouch {report['kilotouch']}; {settings}", left=report.get("left") or 0, cards=cards(report),
               shares=[(v, 100 * report["summary"][v] / total) for v in ("pass", "degraded", "fail")], failed_in=", ".join(f"{k} {v}" for k, v in failed_in), stages=STAGES, rows=rows, charts=histograms(rows))
