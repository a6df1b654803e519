"""compare.html of `kilotouch compare`: runs over each other in plots with one cursor, and their numbers side by side."""
import json
import os

from report_parts.charts import curve_chart
from report_parts.drawing import np
from report_parts.pages import write_page
from report_parts.results import Run, read_json
from report_parts.trace_pictures import indentation
from report_parts.words import FORCE, figures, percent, summary_groups

# A colour is a run here: none of those that stand for a force's part.
LOOKS = [("ink", []), ("purple", [6, 3]), ("green", [2, 2]), ("brown", [6, 2, 2, 2]), ("grey", []), ("purple", [1, 2]), ("green", [6, 2, 2, 2]), ("brown", [2, 2])]
NOTICED = {"no": ("no", ""), "perhaps": ("perhaps", "perhaps"), "yes": ("yes", "no"), None: ("not judged", "perhaps")}  # word -> (word, look of its box)


def over_each_other(runs, values_of, title, y_title, **more):
    """One chart of a quantity of all runs, over the longest time; each with the times of its own."""
    charts = []
    for k, (name, run) in enumerate(runs):
        values = values_of(run)
        if values is not None:
            colour, dash = LOOKS[k % len(LOOKS)]
            charts.append(curve_chart(title, run.trace["t"], [(name, colour, values, {"dash": dash})], y_title, group="time", **more))
    if not charts:
        return None
    out = charts[0]
    for one in charts:
        one["series"][0]["x"] = one["x"]["values"]
    out["series"] = [one["series"][0] for one in charts]
    out["x"] = {"title": "time [s]", "min": min(one["x"]["min"] for one in charts), "max": max(one["x"]["max"] for one in charts)}
    return out


def difference_chart(runs):
    """|F - F of the first| of the others, with what people notice of the first run's force."""
    first = runs[0][1].trace
    t, forces = first["t"], np.column_stack([first[f"force_{axis}"] for axis in "xyz"])
    size = np.linalg.norm(forces, axis=1)
    curves = []
    for k, (name, run) in enumerate(runs[1:], 1):
        trace = run.trace
        inside = t <= trace["t"][-1] * (1 + 1e-9)
        other = np.column_stack([np.interp(t, trace["t"], trace[f"force_{axis}"]) for axis in "xyz"])
        colour, dash = LOOKS[k % len(LOOKS)]
        curves.append((f"{name} against {runs[0][0]}", colour, np.where(inside, np.linalg.norm(other - forces, axis=1), np.nan), {"dash": dash}))
    for share, dash in ((0.07, [2, 3]), (0.10, [6, 3])):
        curves.append((f"{100 * share:.0f} % of {runs[0][0]}'s force", "grey", share * size, {"dash": dash, "width": 1}))
    return curve_chart("How far the forces are apart", t, curves, "[N]", group="time", unit="N",
                       note="People tell forces apart that differ by 7 to 10 %: above the grey lines the difference can be felt.")


def setting(value):
    """As a person writes it in a scene."""
    return "not set" if value is None else f"{value:g}" if isinstance(value, float) else value if isinstance(value, str) else json.dumps(value)


def compare_page(folder):
    facts = read_json(folder, "compare.json")
    if facts is None:
        raise SystemExit(f"report.py: {folder}: no compare.json there")
    runs = [(one["name"], Run(one["folder"])) for one in facts["runs"]]
    drawn = [(name, run) for name, run in runs if run.trace is not None]
    charts = []
    if len(drawn) == len(runs):
        charts = [over_each_other(drawn, lambda run: run.trace["f_n"], "Normal force", "[N]", unit="N"), difference_chart(drawn),
                  over_each_other(drawn, lambda run: run.trace["f_t"], "Tangential force", "[N]", unit="N"),
                  over_each_other(drawn, lambda run: None if indentation(run.trace) is None else 1e3 * indentation(run.trace), "Indentation along the contact normal", "[mm]", unit="mm")]
    verdicts = []
    told = []
    for one in facts["forces"]:
        told.append(one)
        if "second_tool" in one:
            told.append({**one, **one["second_tool"], "run": one["run"] + ", second tool"})
    for one in told:
        word, look = NOTICED[one["noticed"]]
        verdicts.append({"run": one["run"], "against": one["against"], "word": word, "look": look, "same_bits": one["same_bits"], "judged": one["noticed"] is not None, "seconds": figures(one["seconds"]), "rms": FORCE(one["rms_n"]), "rms_share": percent(one["rms_share"]),
                         "largest": FORCE(one["largest_n"]), "largest_share": percent(one["largest_share"]), "at": figures(one["largest_at_s"]), "beyond_7": percent(one["beyond_7_percent"]),
                         "beyond_10": percent(one["beyond_10_percent"]), "apart": f"{figures(1e3 * one['tools_apart_m'])} mm" if one["tools_apart_m"] > 1e-6 else ""})
    settings = [{"key": s["key"], "values": [setting(v) for v in s["values"]]} for s in facts["settings"]]
    titles = list(dict.fromkeys(one["scene"] for one in facts["runs"]))
    write_page(os.path.join(folder, "compare.html"), "compare.html", title=" and ".join(name for name, _ in runs) + " compared", subtitle="; ".join(titles), names=[name for name, _ in runs],
               verdicts=verdicts, settings=settings, charts=[chart for chart in charts if chart], groups=summary_groups([run for _, run in runs]))
