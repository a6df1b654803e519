"""Speed against accuracy: chart.html, and a picture of each chart, from the chart.json of `kilotouch chart`."""
import html
import json
import math
import os
import textwrap

from report_parts.drawing import CAN_DRAW, plt
from report_parts.inline import inline_json
from report_parts.pages import page
from report_parts.notices import with_notice
from report_parts.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION
from report_parts.whole_file import save_figure, write_whole

LIBRARY = "/usr/share/javascript/chart.js/chart.min.js"  # Debian: libjs-chart.js
FAMILIES = {  # colour, matplotlib's marker, Chart.js's
    "ours": (BLACK, "*", "star"), "reducer": (BLUE, "o", "circle"), "baseline": (VERMILION, "X", "crossRot"),
    "global integrator": (GREEN, "s", "rect"), "local integrator": (SKY, "D", "rectRot"),
    "contact law": (PURPLE, "^", "triangle"), "collision backend": (GREY, "P", "cross"), "refresh": (ORANGE, "v", "rectRounded"),
    "springs": (BLUE, "o", "circle"), "4-node elements": (ORANGE, "s", "rect"), "10-node elements": (GREEN, "D", "rectRot"),
}
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


def short(point):
    return point["body"] if point["family"] == "mesh" else point["label"]


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
            axes.scatter([p[cost] for p in families[name]], [p[error] for p in families[name]], c=colour, marker=marker,
                         s=110 if name == "ours" else 42, label=name, zorder=4 if name == "ours" else 3, linewidths=0.5,
                         edgecolors="white" if marker not in "xX" else None)
    front = front_of(points, cost, error)
    if front:
        axes.step([p[cost] for p in front], [p[error] for p in front], where="post", color=GREY, lw=1.2, ls="-", zorder=2)
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
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=min(8, len(handles)), fontsize=10)
    for extension in ("png", "svg"):
        save_figure(figure, os.path.join(folder, f"chart_{chart['name']}.{extension}"))
    plt.close(figure)


CHART_CSS = """<style>
body { max-width: 1280px; } .controls { display: flex; flex-wrap: wrap; gap: 0.4em 1.4em; align-items: center; margin: 0.8em 0; }
.controls label { white-space: nowrap; } select { font: inherit; } .plot { position: relative; height: 640px; }
th.sort { cursor: pointer; } tr.front td:first-child { font-weight: 600; } .scroll { overflow-x: auto; } td { white-space: nowrap; }
th { min-width: 6.5em; } td.command { white-space: normal; font-family: monospace; font-size: 0.85em; min-width: 30em; }
</style>"""

SCRIPT = r"""
const data = JSON.parse(document.getElementById('data').textContent);
const byId = id => document.getElementById(id);
const number = v => typeof v === 'number' && isFinite(v) && v > 0;
const shown = v => v === null || v === undefined ? '–' : typeof v === 'number' ? String(+v.toPrecision(3)) : v;
const panels = [];
for (const chart of data.charts) for (const panel of chart.panels) panels.push({...panel, chart});
const option = (select, value, text) => { const o = document.createElement('option'); o.value = value; o.textContent = text; select.append(o); };
panels.forEach((p, i) => option(byId('panel'), i, p.chart.title + ' – ' + p.name));
data.axes.forEach(a => option(byId(a.is_cost ? 'cost' : 'error'), a.key, a.title));
const families = [...new Set(panels.flatMap(p => p.points.map(q => q.group)))];
for (const f of families) {
  const label = document.createElement('label'), box = document.createElement('input');
  box.type = 'checkbox'; box.checked = true; box.dataset.family = f; box.addEventListener('change', draw);
  const name = document.createElement('span'); name.textContent = ' ' + f; name.style.color = data.styles[f][0]; name.style.fontWeight = 600;
  label.append(box, name); byId('families').append(label);
}
const chosen = f => [...document.querySelectorAll('[data-family]')].some(b => b.dataset.family === f && b.checked);
function front(points, x, y) {
  let best = Infinity; const out = [];
  for (const p of [...points].sort((a, b) => a[x] - b[x] || a[y] - b[y])) if (p[y] < best) { best = p[y]; out.push(p); }
  return out;
}
const limits = {
  id: 'limits',
  afterDraw(chart) {
    const {ctx, chartArea: area, scales: {x, y}} = chart, key = byId('cost').value;
    const line = (x0, y0, x1, y1, text, align) => {
      ctx.save(); ctx.strokeStyle = ctx.fillStyle = '#D55E00'; ctx.setLineDash([6, 4]);
      ctx.beginPath(); ctx.moveTo(x0, y0); ctx.lineTo(x1, y1); ctx.stroke();
      ctx.font = '13px sans-serif'; ctx.textAlign = align; ctx.fillText(text, x1 - 4, y1 - 5); ctx.restore();
    };
    if (byId('error').value === 'force_error') { const v = y.getPixelForValue(100 * data.noticeable); if (v > area.top && v < area.bottom) line(area.left, v, area.right, v, 'noticeable: 10 %', 'right'); }
    if (key.startsWith('tick')) { const v = x.getPixelForValue(1000); if (v > area.left && v < area.right) line(v, area.top, v, area.bottom, '1 ms', 'right'); }
  }
};
let plot = null;
function draw() {
  const panel = panels[byId('panel').value], x = byId('cost').value, y = byId('error').value;
  const all = panel.points.filter(p => chosen(p.group)), points = all.filter(p => number(p[x]) && number(p[y]));
  byId('truth').textContent = panel.truth;
  for (const box of document.querySelectorAll('[data-family]')) box.parentElement.hidden = !panel.points.some(p => p.group === box.dataset.family);
  const missing = all.length - points.length;
  byId('missing').textContent = missing ? missing + ' of ' + all.length + ' methods are not in the picture: they failed, or their value is zero, which a logarithmic axis cannot show; see the table.' : '';
  const sets = families.filter(chosen).map(f => ({
    label: f, data: points.filter(p => p.group === f).map(p => ({x: p[x], y: p[y], p})), backgroundColor: data.styles[f][0],
    borderColor: data.styles[f][0], pointStyle: data.styles[f][1], radius: f === 'ours' ? 10 : 6, hoverRadius: 11, borderWidth: f === 'ours' || f === 'baseline' ? 2.5 : 1 })).filter(s => s.data.length);
  const best = front(points, x, y);
  sets.push({type: 'line', label: 'front: none is faster and more exact', data: best.map(p => ({x: p[x], y: p[y], p})), stepped: true, borderColor: '#777', borderWidth: 1.5, pointRadius: 0, fill: false, backgroundColor: 'transparent'});
  const title = key => data.axes.find(a => a.key === key).title;
  const values = key => points.map(p => p[key]);
  const top = Math.max(...values(x), x.startsWith('tick') ? 1000 : 0) * 1.4;
  if (plot) plot.destroy();
  plot = new Chart(byId('plot'), { type: 'scatter', data: {datasets: sets}, plugins: [limits], options: {
    maintainAspectRatio: false, animation: false,
    scales: { x: {type: 'logarithmic', title: {display: true, text: title(x)}, min: Math.min(...values(x)) / 1.3, max: top},
              y: {type: 'logarithmic', title: {display: true, text: title(y)}, min: Math.min(...values(y)) / 1.3, max: Math.max(...values(y)) * 1.5} },
    plugins: { legend: {position: 'bottom', labels: {usePointStyle: true}}, tooltip: { filter: i => i.dataset.type !== 'line', callbacks: { label: i => {
      const p = i.raw.p; return [p.body + ', ' + p.label, title(y) + ': ' + shown(p[y]), title(x) + ': ' + shown(p[x]), 'dof ' + shown(p.dof) + ', hash ' + shown(p.hash),
        ...p.command.replace('kilotouch run ', '').split(' --set ').slice(1)]; } } } } } });
  table(all, best, x, y);
}
let sorted = null;
function table(points, best, x, y) {
  const columns = [['label', 'method'], ['body', 'body'], ['group', 'family'], ['dof', 'dof'], ...data.axes.map(a => [a.key, a.title]), ['real_time', 'real time'], ['lost_contacts', 'contacts lost'], ['trouble', 'trouble'], ['command', 'command']];
  const key = sorted || y, head = byId('head'), body = byId('rows');
  head.replaceChildren(...columns.map(([k, t]) => { const th = document.createElement('th'); th.textContent = t + (k === key ? ' ▲' : ''); th.className = 'sort'; th.onclick = () => { sorted = k; draw(); }; return th; }));
  const order = v => typeof v === 'number' ? [0, v] : v ? [1, v] : [2, ''];
  const rows = [...points].sort((a, b) => { const [u, v] = [order(a[key]), order(b[key])]; return u[0] - v[0] || (u[1] < v[1] ? -1 : u[1] > v[1] ? 1 : 0); });
  body.replaceChildren(...rows.map(p => { const tr = document.createElement('tr'); if (best.includes(p)) tr.className = 'front';
    tr.append(...columns.map(([k]) => { const td = document.createElement('td'); td.textContent = shown(p[k]); td.className = k === 'command' ? 'command' : typeof p[k] === 'number' ? 'number' : ''; return td; })); return tr; }));
}
for (const id of ['panel', 'cost', 'error']) byId(id).addEventListener('change', draw);
byId('cost').value = 'tick_p50_us'; byId('error').value = 'force_error';
draw();
"""

CONTROLS = """<div class=controls><label>chart <select id=panel></select></label><label>error <select id=error></select></label>
<label>cost <select id=cost></select></label></div><div class=controls id=families></div><p class=note id=truth></p>
<div class=plot><canvas id=plot></canvas></div><p class=note id=missing></p>
<p>Left and low is good. Hover over a point for its settings; the table below holds all numbers and sorts by a click on a column's name.
Methods in front (no other is both faster and more exact) are bold.</p>
<div class=scroll><table><thead><tr id=head></tr></thead><tbody id=rows></tbody></table></div>"""


def chart_page(folder, document):
    """chart.html: everything inside, so that it can be mailed alone."""
    data = {"axes": document["axes"], "noticeable": document["noticeable"], "charts": [],
            "styles": {name: (colour, style) for name, (colour, _, style) in FAMILIES.items()}}
    for chart in document["charts"]:
        panels = [{"name": name, "truth": truth_line(chart, name), "points": [dict(p, group=family_of(chart, p)) for p in points]}
                  for name, points in panels_of(chart)]
        data["charts"].append({"title": chart["title"], "panels": panels})
    try:
        with open(LIBRARY, encoding="utf-8") as file:
            library = with_notice("Chart.js", file.read())
    except OSError:
        library = None
    subtitle = (f"{sum(len(c['points']) for c in document['charts'])} runs in {document['seconds'] / 60:.1f} minutes on "
                f"{html.escape(document['processor'])}; costs are CPU times")
    if library is None:
        body = f"<p class=warnings>{LIBRARY} is missing (Debian: libjs-chart.js), hence still pictures.</p>" + "".join(
            open(os.path.join(folder, f"chart_{chart['name']}.svg"), encoding="utf-8").read()
            for chart in document["charts"] if os.path.exists(os.path.join(folder, f"chart_{chart['name']}.svg")))
    else:
        inside = inline_json(data)
        body = (f"{CONTROLS}<script type='application/json' id=data>{inside}</script><script>{library}</script><script>{SCRIPT}</script>")
    write_whole(os.path.join(folder, "chart.html"), page("Speed against accuracy", subtitle, CHART_CSS + body))


def chart_report(folder):
    with open(os.path.join(folder, "chart.json"), encoding="utf-8") as file:
        document = json.load(file)
    document["charts"] = [chart for chart in document["charts"] if chart["points"]]  # stopped before: nothing to draw
    titles = {axis["key"]: axis["title"] for axis in document["axes"]}
    if CAN_DRAW:
        for chart in document["charts"]:
            draw_chart(folder, chart, titles, document["noticeable"])
    chart_page(folder, document)
