#!/usr/bin/python3
"""Tables, pictures and CSV files about local models from what scripts/multirate measured in RESULTS. Tables go between
the markers <!-- multirate:NAME begin --> and <!-- multirate:NAME end --> of DOCUMENT. A part without results is left as
it is.

    scripts/multirate.py RESULTS docs/accuracy_and_speed.md docs/pictures bench/results
"""
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

from measured import machine, percent as some_percent, put_between, read_csv, read_json, table, write_csv  # noqa: E402
from report_parts.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, STYLE, VERMILION  # noqa: E402

plt.rcParams.update(STYLE)
OCHRE = "#8A7300"  # Okabe and Ito's yellow is too light for a line
METHODS = {  # name -> (label, colour, marker)
    "wall1": ("wall, 1 ring", ORANGE, "o"), "wall3": ("wall, 3 rings", VERMILION, "s"),
    "condensed": ("condensed", SKY, "^"), "krylov": ("krylov", BLUE, "D"), "auto": ("auto", BLACK, "*"),
    "krylov_no_look_ahead": ("krylov, no look-ahead", BLUE, "v"), "krylov_early": ("krylov, early refreshes", BLUE, "d"), "modal": ("modal", PURPLE, "P"),
    "hold": ("hold", GREY, "v"), "hold_condensed": ("hold, condensed", GREY, "v"), "legacy": ("legacy", PURPLE, "<"),
    "frozen": ("frozen", GREEN, ">"), "frozen_condensed": ("frozen, condensed", GREEN, ">"),
    "penalty": ("penalty", OCHRE, "X"), "penalty_condensed": ("penalty, condensed", OCHRE, "X")}
MODELS = {"msd": "springs", "fem": "neo-Hookean elements"}
LATE = {0: "at once", 1: "one frame late"}
SWITCHES = {"krylov_bare": ("off", "off"), "krylov_catch_up": ("on", "off"), "krylov_blend": ("off", "on"),
            "krylov": ("on", "on")}


def load(folder, name):
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        print(f"no {name}: its part stays as it is")
        return None
    return read_json(path)


def headline(model):
    name = MODELS.get(model, model)
    return name[0].upper() + name[1:]


def unique(values):
    return list(dict.fromkeys(values))


def pick(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def percent(value):
    return "failed" if value is None else some_percent(value)


class Output:
    def __init__(self, document, pictures, results):
        self.document, self.pictures, self.results = document, pictures, results
        os.makedirs(results, exist_ok=True)
        os.makedirs(pictures, exist_ok=True)

    def section(self, name, text):
        put_between(self.document, f"multirate:{name}", text)

    def csv(self, name, rows):
        write_csv(os.path.join(self.results, f"multirate_{name}.csv"), f"scripts/multirate; {machine()}", rows)

    def picture(self, figure, name):
        figure.savefig(os.path.join(self.pictures, f"multirate_{name}.png"), bbox_inches="tight", pad_inches=0.1)
        plt.close(figure)


def limit_lines(panel, limits=(5, 10), where="left"):
    for limit in limits:
        panel.axhline(limit, color="0.6", linewidth=1, zorder=0)
        panel.annotate(f"{limit} %", (0 if where == "left" else 1, limit), xycoords=("axes fraction", "data"), xytext=(3 if where == "left" else -3, 2),
                       textcoords="offset points", color="0.4", fontsize=9, ha=where)


def percent_axis(panel):
    panel.set_yscale("log")
    panel.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    low, high = panel.get_ylim()
    ticks = [m * 10**e for e in range(-3, 4) for m in ((1, 2, 5) if high / low < 300 else (1,)) if low <= m * 10**e <= high]
    panel.set_yticks(ticks)
    panel.minorticks_off()


# --- Impedance

def impedance(data, out):
    hz, fragments, rows = data["hz"], [], []
    families = {"wall": (ORANGE, VERMILION, OCHRE), "condensed": (SKY,), "modal": (PURPLE,), "krylov": (BLUE, BLACK, GREEN, GREY)}
    hidden = ("wall, 1 ring in depth", "wall, 2 rings in depth", "wall, 4 rings in depth", "krylov {0, 60}, whole body",
              "krylov, whole, no echoes", "krylov, graded, none dropped", "krylov, 10 refreshes later", "krylov, coarse",
              "krylov {0, 60, 250}", "krylov {0, 20, 40, 80, 160, 400}")
    bodies = data["bodies"]
    figure, panels = plt.subplots(1, len(bodies), figsize=(4.8 * len(bodies), 6.6), sharey=True, squeeze=False)
    floor = 0.01
    for body, panel in zip(bodies, panels[0]):
        fragments.append(f"**{body['body']}**\n\n" + table(
            ["local model", "dof"] + [f"{f:g} Hz" for f in hz],
            [[row["reducer"], row["dof"]] + [percent(e) if e >= 5e-6 else "0" for e in row["error"]] for row in body["rows"]]))
        members = {}  # family -> its rows; a row that begins with no family's name belongs to the one before it
        family = ""
        for row in body["rows"]:
            rows.append({"body": body["body"], "reducer": row["reducer"], "dof": row["dof"],
                         **{f"error_{f:g}_hz": e for f, e in zip(hz, row["error"])}})
            first = row["reducer"].split()[0].rstrip(",")
            family = first if first in families or not family else family
            if row["reducer"] not in hidden:
                members.setdefault(family, []).append(row)
        for family, group in members.items():
            for count, row in enumerate(group if len(group) <= 4 else [group[0], *group[-3:]]):  # more cannot be told apart
                panel.plot(range(len(hz)), [max(floor, 100 * e) for e in row["error"]], color=families.get(family, (GREEN,))[count % 4 % len(families.get(family, (GREEN,)))],
                           marker="osD^"[count], markersize=4.5, linestyle=("-", "--", "-.", ":")[count], label=f"{row['reducer']} ({row['dof']} dof)")
        panel.set(xticks=range(len(hz)), xticklabels=[f"{f:g}" for f in hz], xlabel="frequency [Hz]",
                  title=body["body"].split(" (")[0])
        panel.legend(loc="upper center", bbox_to_anchor=(0.45, -0.14), fontsize=10)
    panels[0][0].set(ylabel="error of the impedance [%]", ylim=(0.75 * floor, 300))
    for panel in panels[0]:
        percent_axis(panel)
        limit_lines(panel, (5,))
        panel.yaxis.set_major_formatter(lambda value, _: f"{value:g}" if value > 1.5 * floor else f"≤ {floor:g}")
    figure.tight_layout()
    out.picture(figure, "impedance")
    out.csv("impedance", rows)
    limit = 0.05
    good = []
    for body in bodies:
        rows_below = [r for r in body["rows"] if max(r["error"]) < limit]
        least = min(rows_below, key=lambda r: r["dof"]) if rows_below else None
        good.append(f"{body['body'].split(' (')[0]}: " + (f"{least['reducer']} ({least['dof']} dof)" if least else "none"))
    fragments.append(f"The smallest below {100 * limit:g} % in the whole band: " + "; ".join(good) + ".")
    out.section("impedance", "\n\n".join(fragments) + "\n\n![Impedance error](pictures/multirate_impedance.png)")


# --- Force error

def force_row(rows, model, method, cells):
    out = []
    for rate, late in cells:
        found = pick(rows, model=model, method=method, rate_hz=rate, latency_frames=late)
        out.append(percent(found[0]["force_error"]) if found else "-")
    return out


def force_figure(rows, methods, name, out):
    rates, models = sorted(unique(r["rate_hz"] for r in rows)), unique(r["model"] for r in rows)
    figure, panels = plt.subplots(1, len(models), figsize=(5.6 * len(models), 4.6), sharey=True, squeeze=False)
    for model, panel in zip(models, panels[0]):
        for method in methods:
            _, colour, marker = METHODS[method]
            wide = 2 if method == "condensed" else 1  # it is hidden by krylov where they agree
            for late, style in ((0, "-"), (1, "--")):
                found = [r for r in pick(rows, model=model, method=method, latency_frames=late) if r["force_error"] is not None]
                panel.plot([rates.index(r["rate_hz"]) for r in found], [100 * r["force_error"] for r in found], style,
                           color=colour, marker=marker, markersize=2 + 4 * wide,
                           linewidth=1.5 * wide, zorder=3 - wide, markerfacecolor=colour if late == 0 else "white")
        panel.set(xticks=range(len(rates)), xticklabels=[f"{r:g}" for r in rates], xlabel="global rate [Hz]", title=headline(model),
                  xlim=(-0.25, len(rates) - 0.75))
    panels[0][0].set_ylabel("force error [%]")
    for panel in panels[0]:
        percent_axis(panel)
        limit_lines(panel)
    handles = [Line2D([], [], color=METHODS[m][1], marker=METHODS[m][2], label=METHODS[m][0]) for m in methods]
    styles = [Line2D([], [], color=BLACK, linestyle="-", marker="o", label="model used at once"),
                Line2D([], [], color=BLACK, linestyle="--", marker="o", markerfacecolor="white", label="model one frame late")]
    figure.tight_layout()
    figure.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.01), ncol=len(handles), columnspacing=1.5)
    figure.legend(handles=styles, loc="upper center", bbox_to_anchor=(0.5, -0.05), ncol=2, columnspacing=1.5)
    out.picture(figure, name)


def kinder(measured, names):
    """Of a baseline the form with the better local model below, where that was measured."""
    chosen = [name + "_condensed" if name + "_condensed" in measured else name for name in names]
    return [name for name in chosen if name in measured]


def losses(rows, ours):
    """Where another method is nearer to the reference than `ours`."""
    lines = []
    for row in rows:
        if row["method"] != ours or row["force_error"] is None:
            continue
        peers = [r for r in pick(rows, model=row["model"], rate_hz=row["rate_hz"], latency_frames=row["latency_frames"])
                 if r["force_error"] is not None and not r["method"].startswith("krylov") and r["method"] != ours]
        best = min(peers, key=lambda r: r["force_error"], default=None)
        if best and best["force_error"] < 0.98 * row["force_error"]:
            lines.append(f"{MODELS.get(row['model'], row['model'])}, {row['rate_hz']:g} Hz, {LATE[row['latency_frames']]}: "
                         f"{METHODS[best['method']][0]} {percent(best['force_error'])}, {METHODS[ours][0]} {percent(row['force_error'])}")
    return lines


def force(rows, deep, out):
    methods = [m for m in METHODS if m in {r["method"] for r in rows}]
    rates, models = sorted(unique(r["rate_hz"] for r in rows)), unique(r["model"] for r in rows)
    cells = [(rate, late) for rate in rates for late in sorted(unique(r["latency_frames"] for r in rows))]
    head = ["method", "dof"] + [f"{rate:g} Hz, {LATE[late]}" for rate, late in cells]
    fragments = []
    for model in models:
        any_row = next((r for r in pick(rows, model=model) if "nodes" in r), None)
        size = f"{any_row['nodes']} nodes, mean force {any_row['mean_force']:.3f} N" if any_row else "no run ended"
        lines = []
        for method in methods:
            dofs = unique(r["dof"] for r in pick(rows, model=model, method=method) if "dof" in r)
            span = "-" if not dofs else f"{min(dofs)}" if len(dofs) == 1 else f"{min(dofs)}-{max(dofs)}"
            lines.append([METHODS[method][0], span] + force_row(rows, model, method, cells))
        fragments.append(f"**{headline(model)}** ({size})\n\n" + table(head, lines))
    lost = losses(rows, "krylov")
    fragments.append("Nearer to the reference than krylov: " + ("; ".join(lost) + "." if lost else "nothing, in no cell."))
    early = [r for r in pick(rows, method="krylov_early") if r.get("refreshes_per_s")]
    if early:
        counts = "; ".join(f"{MODELS.get(m, m)} " + ", ".join(f"{r['refreshes_per_s']:.0f} for {r['rate_hz']:g} Hz" for r in pick(early, model=m, latency_frames=0))
                           for m in models if pick(early, model=m, latency_frames=0))
        fragments.append(f"Early refreshes (`global.early_refresh`, on by default, off in all other rows) refreshed so often a second: {counts}.")
    if deep:
        fragments.append("At 4 mm, a full radius of the tool, 30 Hz, at once: " + "; ".join(
            f"{MODELS.get(model, model)}, {', '.join(METHODS[r['method']][0] + ' ' + percent(r['force_error']) for r in pick(deep, model=model))}"
            f" ({max((r.get('inside_out', 0) for r in pick(deep, model=model)), default=0)} tetrahedra inside out)"
            for model in unique(r["model"] for r in deep)) + ".")
    fragments.append("![Force error of the reducers](pictures/multirate_force_reducers.png)")
    fragments.append("![Force error of ours and of the baselines](pictures/multirate_force_baselines.png)")
    force_figure(rows, [m for m in ("wall1", "wall3", "condensed", "krylov", "auto") if m in methods], "force_reducers", out)
    force_figure(rows, kinder(methods, ("krylov", "hold", "legacy", "frozen", "penalty")), "force_baselines", out)
    out.csv("force", [flat(r) for r in rows + [dict(r, depth_m=0.004) for r in deep or []]])
    out.section("force", "\n\n".join(fragments))


def flat(row):
    """{"step_us": {"p50": 1}} as step_us_p50."""
    out = {}
    for key, value in row.items():
        if isinstance(value, dict):
            out.update({f"{key}_{inner}": v for inner, v in value.items()})
        else:
            out[key] = value
    return out


# --- Refresh

def read_trace(folder, name):
    rows = read_csv(os.path.join(folder, "traces", name + ".csv"))
    t = [float(r["t"]) for r in rows]
    size = [sum(float(r["force_" + c]) ** 2 for c in "xyz") ** 0.5 for r in rows]
    return t, size, [float(r["t"]) for r in rows if r["refresh"] == "1"]


def refresh(rows, folder, out):
    rates, models = sorted(unique(r["rate_hz"] for r in rows)), unique(r["model"] for r in rows)
    cells = [(rate, late) for rate in rates for late in sorted(unique(r["latency_frames"] for r in rows))]
    fragments = []
    for model in models:
        lines = []
        for method, (catch_up, blend) in SWITCHES.items():
            line = [catch_up, blend]
            for rate, late in cells:
                found = pick(rows, model=model, method=method, rate_hz=rate, latency_frames=late)
                ok = found and found[0]["force_error"] is not None
                line.append(f"{percent(found[0]['refresh_jump'])} ({percent(found[0]['force_error'])})" if ok else "failed" if found else "-")
            lines.append(line)
        fragments.append(f"**{headline(model)}**\n\n" + table(
            ["catch-up", "blend"] + [f"{rate:g} Hz, {LATE[late]}" for rate, late in cells], lines))
    rate, late = 30, 1
    drawn = [m for m in models if all(os.path.exists(os.path.join(folder, "traces", f"{m}_{method}_{rate}_{late}.csv"))
                                      for method in ("krylov_bare", "krylov"))]
    if drawn:
        refresh_figure(folder, "fem" if "fem" in drawn else drawn[-1], rate, late, out)
        fragments.append(f"![Force over refreshes](pictures/multirate_refresh.png)\n\nOf {MODELS.get('fem' if 'fem' in drawn else drawn[-1])}, "
                         f"{rate} Hz, local models {LATE[late]}.")
    out.csv("refresh", [flat(r) for r in rows])
    out.section("refresh", "\n\n".join(fragments))


def refresh_figure(folder, model, rate, late, out):
    window = (0.5, 0.8)
    figure, panels = plt.subplots(2, 1, figsize=(9.5, 5.6), sharex=True, sharey=True)
    t_ref, f_ref, _ = read_trace(folder, f"{model}_reference")
    for panel, (method, title) in zip(panels, (("krylov_bare", "Catch-up and blend off"), ("krylov", "Catch-up and blend on"))):
        t, f, at = read_trace(folder, f"{model}_{method}_{rate}_{late}")
        keep = [i for i, time in enumerate(t) if window[0] <= time <= window[1]]
        refs = [i for i, time in enumerate(t_ref) if window[0] <= time <= window[1]]
        for k, time in enumerate(x for x in at if window[0] <= x <= window[1]):
            panel.axvline(time, color="0.85", linewidth=1, zorder=0, label="new local model" if k == 0 else None)
        panel.plot([t_ref[i] for i in refs], [f_ref[i] for i in refs], color=BLACK, linestyle="--", label="reference")
        panel.plot([t[i] for i in keep], [f[i] for i in keep], color=BLUE if method == "krylov" else VERMILION, label="force on the tool")
        panel.set(title=title, ylabel="force [N]", xlim=window)
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    panels[-1].set_xlabel("time [s]")
    figure.tight_layout()
    out.picture(figure, "refresh")


# --- Cost

def cost(ticks, force_rows, out):
    lines, rows = [], []
    for b in ticks["benchmarks"]:
        name = b["name"].split("/")[1]
        lines.append([METHODS[name][0], f"{b['dof']:.0f}", f"{b['patch_vertices']:.0f}", f"{b['contacts']:.1f}", f"{b['p50_us']:.1f}", f"{b['p999_us']:.1f}"])
        rows.append({"what": "tick", "reducer": name, "nodes": 3703, **{k: b[k] for k in ("dof", "patch_vertices", "contacts", "p50_us", "p999_us", "max_us")}})
    fragments = [table(["reducer", "dof", "patch vertices", "contacts, mean", "tick, median [µs]", "tick, p99.9 [µs]"], lines)]
    if force_rows:
        cost_figure(force_rows, out)
        fragments.append("![Force error against the cost of a tick](pictures/multirate_cost.png)")
    out.csv("cost", rows)
    out.section("cost", "\n\n".join(fragments))


def cost_figure(rows, out):
    models = unique(r["model"] for r in rows)
    figure, panels = plt.subplots(1, len(models), figsize=(5.6 * len(models), 4.4), sharey=True, squeeze=False)
    shown = []
    measured = {r["method"] for r in rows}
    shown_methods = kinder(measured, ("wall1", "wall3", "condensed", "krylov", "auto", "hold", "legacy", "frozen", "penalty"))
    for model, panel in zip(models, panels[0]):
        for row in pick(rows, model=model, rate_hz=30, latency_frames=0):
            if row["force_error"] is None or row["method"] not in shown_methods:
                continue
            label, colour, marker = METHODS[row["method"]]
            us, error = row["step_us"], 100 * row["force_error"]
            panel.plot([us["p50"], us["p99"]], [error, error], color=colour, linewidth=1, alpha=0.6)
            panel.plot(us["p50"], error, marker, color=colour, markersize=8, linestyle="none")
            shown.append((label, colour, marker))
        panel.set(xscale="log", xlabel="tick: median, and line to p99 [µs]", title=f"{headline(model)}, 30 Hz")
        panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        low, high = panel.get_xlim()
        panel.set_xticks([x for x in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000) if low <= x <= high])
        panel.minorticks_off()
    panels[0][0].set_ylabel("force error [%]")
    for panel in panels[0]:
        percent_axis(panel)
        limit_lines(panel, where="right")
    figure.tight_layout()
    figure.legend(handles=[Line2D([], [], color=c, marker=m, linestyle="none", markersize=8, label=l) for l, c, m in unique(shown)],
                  loc="upper center", bbox_to_anchor=(0.5, 0.01), ncol=5, columnspacing=1.5)
    out.picture(figure, "cost")


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    folder, document, pictures, results = sys.argv[1:]
    out = Output(document, pictures, results)
    table_of_impedance, rows, switched = (load(folder, name) for name in (
        "impedance.json", "force.json", "refresh.json"))
    ticks = load(folder, "tick.json")
    if table_of_impedance:
        impedance(table_of_impedance, out)
    if rows:
        force(rows, load(folder, "deep.json"), out)
    if rows and switched:
        refresh(switched + pick(rows, method="krylov"), folder, out)
    if ticks:
        cost(ticks, rows, out)


if __name__ == "__main__":
    main()
