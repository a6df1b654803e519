"""report.html of `kilotouch check`: one page that needs nothing else, for one mesh or for thousands."""
import base64
import html
import io
import json
import os

from report_parts.drawing import CAN_DRAW, np, plt
from report_parts.inline import inline_json
from report_parts.style import BLUE, GREEN, GREY, ORANGE, VERMILION
from report_parts.notices import with_notice
from report_parts.thumbnail import thumbnail
from report_parts.whole_file import write_whole

SCRIPTS = ("/usr/share/javascript/jquery/jquery.min.js", "/usr/share/javascript/jquery-datatables/jquery.dataTables.min.js")
STAGES = ("load", "doctor", "repair", "queries", "shots", "solid", "models", "local_models", "press", "drag", "energy")
COLOURS = {"pass": GREEN, "degraded": ORANGE, "fail": VERMILION, "skipped": GREY}
LARGE_PICTURES = 400  # of places where something failed: more would make the page heavy

CSS = """
body { font: 14px/1.45 system-ui, 'DejaVu Sans', sans-serif; color: #1a1a1a; margin: 1.4em 2em; }
h1 { font-size: 1.6em; margin: 0; } h2 { margin: 1.4em 0 0.5em; font-size: 1.2em; } .sub { color: #555; margin: 0.1em 0 0; }
.cards { display: flex; flex-wrap: wrap; gap: 0.7em; margin: 1em 0; }
.card { border: 1px solid #ccc; border-radius: 8px; padding: 0.5em 1em; min-width: 110px; } .card b { display: block; font-size: 1.5em; }
.card span { color: #555; } .pictures img { max-width: 100%; height: auto; }
.bar { display: flex; height: 12px; border-radius: 6px; overflow: hidden; margin: 0.4em 0 1em; } .bar i { display: block; }
.tools { display: flex; flex-wrap: wrap; gap: 0.6em; align-items: center; margin: 0.6em 0; }
.tools button { font: inherit; padding: 0.2em 0.8em; border: 1px solid #bbb; border-radius: 14px; background: #fff; cursor: pointer; }
.tools button.on { background: #1a1a1a; color: #fff; border-color: #1a1a1a; }
.tools select { font: inherit; padding: 0.2em; }
.tag { border-radius: 10px; padding: 0.05em 0.6em; color: #fff; font-weight: 600; white-space: nowrap; display: inline-block; }
.pass { background: #00694c; } .degraded { background: #8a5a00; } .fail { background: #a83f00; } .skipped { background: #777; }
table.dataTable { border-collapse: collapse; width: 100%; }
table.dataTable th { text-align: left; border-bottom: 2px solid #999; padding: 0.3em 0.35em; cursor: pointer; white-space: nowrap; font-weight: 600; }
table.dataTable td { border-bottom: 1px solid #e5e5e5; padding: 0.25em 0.35em; vertical-align: middle; }
table.dataTable td.n, table.dataTable th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
table.dataTable tbody tr.row { cursor: pointer; } table.dataTable tbody tr.row:hover { background: #f3f7fa; }
th.sorting_asc::after { content: ' ▲'; font-size: 0.7em; } th.sorting_desc::after { content: ' ▼'; font-size: 0.7em; }
td img { display: block; } .why { font-size: 0.85em; min-width: 17em; max-width: 34em; overflow-wrap: break-word; } .path { min-width: 7em; max-width: 20em; overflow-wrap: anywhere; }
.detail { display: flex; gap: 1.5em; flex-wrap: wrap; padding: 0.6em 0 1em; } .detail table { border-collapse: collapse; max-width: 900px; }
.detail td { border-bottom: 1px solid #eee; padding: 0.2em 0.8em 0.2em 0; vertical-align: top; overflow-wrap: anywhere; } .detail pre { margin: 0; font-size: 0.85em; white-space: pre-wrap; color: #555; }
.dataTables_length, .dataTables_filter, .dataTables_info { display: inline-block; margin-right: 2em; } .dataTables_paginate { float: right; }
.dataTables_filter input { margin-left: 0.5em; font: inherit; padding: 0.2em 0.5em; width: 22em; } .paginate_button { padding: 0.15em 0.6em; cursor: pointer; } .paginate_button.current { font-weight: 700; text-decoration: underline; }
.paginate_button.disabled { color: #bbb; cursor: default; } pre.command { background: #f4f4f4; padding: 0.6em 1em; border-radius: 6px; }
"""

SCRIPT = """
const rows = JSON.parse(document.getElementById('rows').textContent);
const escaped = s => String(s).replace(/[&<>"'`=\\/]/g, c => '&#' + c.charCodeAt(0) + ';');
// Escaped for every use: DataTables makes elements of what it searches, too. It reads the text back from them.
const words = d => escaped(d);
const finite = v => typeof v === 'number' && isFinite(v);
const number = (digits, factor) => (v, type) => type !== 'display' ? (finite(v) ? v : -1) : finite(v) ? String(+(v * (factor || 1)).toPrecision(digits)) : '–';
const tag = v => '<span class="tag ' + (v in order || v === 'skipped' ? v : '') + '">' + escaped(v) + '</span>';
const image = (src, alt) => /^data:image.png;base64,[A-Za-z0-9+/=]+$/.test(src) ? '<img alt="' + alt + '" src="' + src + '">' : '';
const order = {fail: 0, degraded: 1, pass: 2};
function detail(r) {
  const where = w => w ? '<br>at (' + w.map(c => finite(c) ? +c.toPrecision(6) : 'NaN').join(', ') + ')' : '';
  const stages = r.stages.map(s => '<tr><td>' + escaped(s[0]) + '</td><td>' + tag(s[1]) + '</td><td>' +
    escaped(s[2]) + where(s[3]) + '</td><td><pre>' + escaped(s[4]) + '</pre></td></tr>').join('');
  return '<div class=detail>' + image(r.large, 'where it failed') + '<table>' + stages + '</table></div>';
}
$(function () {
  const table = $('#table').DataTable({
    data: rows, deferRender: true, autoWidth: false, pageLength: 50, lengthMenu: [25, 50, 100, 500], order: [[2, 'asc'], [1, 'asc']],
    language: {search: 'search', lengthMenu: '_MENU_ a page', info: '_START_ – _END_ of _TOTAL_', infoFiltered: '(of _MAX_)', paginate: {previous: '‹', next: '›'}},
    createdRow: tr => tr.classList.add('row'),
    columns: [
      {data: 'picture', orderable: false, searchable: false, render: d => image(d, '')},
      {data: 'path', className: 'path', render: words},
      {data: 'verdict', render: (d, type) => type === 'sort' ? order[d] : type === 'display' ? tag(d) : escaped(d)},
      {data: 'stage', render: words},
      {data: 'why', className: 'why', render: (d, type) => escaped(type === 'display' && d.length > 160 ? d.slice(0, 160) + ' …' : d)},
      {data: 'triangles', className: 'n', render: number(7)},
      {data: 'moved', className: 'n', render: number(2, 100)},
      {data: 'error', className: 'n', render: number(2, 100)},
      {data: 'off', className: 'n', render: number(2, 100)},
      {data: 'buzz', className: 'n', render: number(2, 100)},
      {data: 'step_us', className: 'n', render: number(3)},
      {data: 'refresh_ms', className: 'n', render: number(3)},
      {data: 'cpu_s', className: 'n', render: number(3)}]});
  let verdict = '', stage = '';
  $.fn.dataTable.ext.search.push((s, d, i) => (!verdict || rows[i].verdict === verdict) && (!stage || rows[i].stage === stage));
  $('.tools button').on('click', function () { $('.tools button').removeClass('on'); $(this).addClass('on'); verdict = this.dataset.verdict; table.draw(); });
  $('#stage').on('change', function () { stage = this.value; table.draw(); });
  $('#table tbody').on('click', 'tr.row', function () { const r = table.row(this); if (r.child.isShown()) r.child.hide(); else r.child(detail(r.data())).show(); });
});
"""

HEADS = (("", ""), ("mesh", ""), ("verdict", ""), ("stage", "the first that is as bad as the verdict"), ("why", ""),
         ("triangles", ""), ("moved %", "how far repair, decimation or wrapping moved the surface, of its size"),
         ("certified %", "largest certified error of a local model's impedance"),
         ("force %", "force of a press against the whole nonlinear body along the same path, larger of both models"),
         ("buzz %", "force above 100 Hz over the mean, while dragged"), ("step µs", "99 of 100 haptic ticks take less"),
         ("refresh ms", "median time to a new local model"), ("CPU s", "of the whole check"))


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
        if isinstance(value, float):
            return f"{value:.3g}"
        if isinstance(value, dict):
            return "{" + ", ".join(f"{k} {short(v)}" for k, v in value.items()) + "}"
        if isinstance(value, list):
            return f"[{', '.join(short(v) for v in value[:4])}{', …' if len(value) > 4 else ''}]"
        return str(value)
    both = dict(stage.get("figures") or {}, **(stage.get("times") or {}))
    return "\n".join(f"{key}: {short(value)}" for key, value in both.items() if value not in (0, [], {}))


def table_rows(report, outlines):
    many = len(report["rows"]) > 1000
    width, height = (60, 46) if many else (96, 72)
    out, large = [], 0
    for row in report["rows"]:
        outline, where = outlines.get(row["path"]), row.get("where")
        entry = {"path": row["path"], "verdict": row["verdict"], "stage": row["stage"], "why": row["why"], "triangles": row["triangles"],
                 "picture": thumbnail(outline, where, width, height), "large": ""}
        entry.update(numbers_of(row))
        if where and row["verdict"] != "pass" and large < LARGE_PICTURES:
            entry["large"] = thumbnail(outline, where, 320, 240)
            large += 1
        # What passed has its numbers in report.json; here they would make a page of thousands slow.
        detailed = not many or row["verdict"] == "fail"
        entry["stages"] = [[s["name"], s["verdict"], s["why"], s.get("where"), figures_text(s) if detailed else ""] for s in row["stages"]]
        out.append(entry)
    return out


def histogram(axes, values, title, label, colour=BLUE):
    values = [v for v in values if isinstance(v, (int, float)) and np.isfinite(v)]
    axes.set_title(title)
    axes.set_xlabel(label)
    axes.set_ylabel("meshes")
    positive = [v for v in values if v > 0]
    if not positive:
        axes.text(0.5, 0.5, "none" if not values else "all zero", ha="center", va="center", transform=axes.transAxes, color=GREY)
        return
    low, high = min(positive), max(positive)
    axes.hist(positive, bins=np.geomspace(low / 1.05, high * 1.05, 25), color=colour)
    axes.set_xscale("log")
    axes.margins(y=0.25)  # room for the words
    axes.yaxis.get_major_locator().set_params(integer=True)
    zero = len(values) - len(positive)
    axes.text(0.98, 0.95, f"{len(values)} meshes, median {float(format(np.median(values), '.2g')):g}" + (f"\n{zero} are 0" if zero else ""), ha="right", va="top",
              transform=axes.transAxes, fontsize=9, color="#444444")


def histograms(rows):
    figure, axes = plt.subplots(2, 3, figsize=(14, 5.6), constrained_layout=True)
    scaled = lambda key, factor=1: [abs(r[key]) * factor for r in rows if r[key] is not None]
    histogram(axes[0][0], scaled("step_us"), "Haptic tick", "99 of 100 ticks take less [µs]")
    if axes[0][0].get_xscale() == "log":
        axes[0][0].axvline(1000, color=VERMILION, linestyle=":")
    histogram(axes[0][1], scaled("refresh_ms"), "New local model", "median [ms]")
    histogram(axes[0][2], scaled("cpu_s"), "Whole check", "CPU time [s]")
    histogram(axes[1][0], scaled("error", 100), "Certified error of the local model", "% of the impedance, 0–500 Hz", ORANGE)
    histogram(axes[1][1], scaled("off", 100), "Held force against the nonlinear body", "%", ORANGE)
    histogram(axes[1][2], scaled("buzz", 100), "Buzz while dragged", "% of the force", ORANGE)
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=80)
    plt.close(figure)
    return "<img alt='histograms of times and errors' src='data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii") + "'>"


def cards(report):
    s, t = report["summary"], report["times"]
    shown = [(s["meshes"], "meshes"), (s["pass"], "pass"), (s["degraded"], "degraded"), (s["fail"], "fail"), (f"{s['triangles']:,}", "triangles"),
             (f"{t['cpu_s']:.0f} s", "CPU time")]
    if t.get("cpu_s_per_100000_triangles"):
        shown.append((f"{t['cpu_s_per_100000_triangles']:.0f} s", "CPU time per 10⁵ triangles"))
    total = max(1, s["meshes"])
    bar = "".join(f"<i style='width:{100 * s[v] / total}%;background:{COLOURS[v]}' title='{v}'></i>" for v in ("pass", "degraded", "fail"))
    return "<div class=cards>" + "".join(f"<div class=card><b>{value}</b><span>{name}</span></div>" for value, name in shown) + f"</div><div class=bar>{bar}</div>"


def failed_in(report):
    by_stage = report["summary"].get("failed_in") or {}
    if not by_stage:
        return ""
    return "<p class=sub>failed in: " + ", ".join(f"{html.escape(k)} {v}" for k, v in sorted(by_stage.items(), key=lambda e: -e[1])) + "</p>"


def script_files():
    """jQuery and DataTables, of Debian's libjs-jquery and libjs-jquery-datatables. Without them the table cannot be shown."""
    if not all(os.path.exists(path) for path in SCRIPTS):
        return None
    scripts = (with_notice(name, open(path, encoding="utf-8").read()) for name, path in zip(("jQuery", "DataTables"), SCRIPTS))
    return "".join("<script>" + script.replace("</script", "<\\/script") + "</script>" for script in scripts)


def plain_table(rows):
    """Where the scripts are missing."""
    image = lambda source: f"<img alt='' src='{source}'>" if source else ""  # our own: thumbnail.py
    lines = "".join(f"<tr><td>{image(r['picture'])}</td><td>{html.escape(r['path'])}</td>"
                    f"<td><span class='tag {r['verdict']}'>{r['verdict']}</span></td><td>{html.escape(r['stage'])}</td><td>{html.escape(r['why'])}</td></tr>" for r in rows)
    return f"<table class=dataTable><tr><th></th><th>mesh</th><th>verdict</th><th>stage</th><th>why</th></tr>{lines}</table>"


def check_page(folder):
    with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
        report = json.load(file)
    try:
        with open(os.path.join(folder, "outlines.json"), encoding="utf-8") as file:
            outlines = json.load(file)
    except OSError:
        outlines = {}
    rows = table_rows(report, outlines)
    scripts = script_files()
    settings = ", ".join(f"{key} {value}" for key, value in report["settings"].items())
    body = f"<h1>Mesh check</h1><p class=sub>kilotouch {html.escape(report['kilotouch'])}; {html.escape(settings)}</p>{cards(report)}{failed_in(report)}"
    if scripts:
        stages = "".join(f"<option>{name}</option>" for name in STAGES)
        buttons = "".join(f"<button data-verdict='{v}' class='{'' if v else 'on'}'>{v or 'all'}</button>" for v in ("", "fail", "degraded", "pass"))
        heads = "".join(f"<th title='{html.escape(hint)}'>{name}</th>" for name, hint in HEADS)
        data = inline_json(rows)
        body += (f"<div class=tools>{buttons}<select id=stage><option value=''>any stage</option>{stages}</select>"
                 f"<span class=sub>a row opens its stages; places are in the file's own coordinates</span></div>"
                 f"<table id=table class=dataTable><thead><tr>{heads}</tr></thead></table>")
        body += f"<h2>Times and errors</h2><div class=pictures>{histograms(rows)}</div>" if CAN_DRAW else ""
        body += f"<script type='application/json' id=rows>{data}</script>{scripts}<script>{SCRIPT}</script>"
    else:
        body += "<p class=sub>Not sortable: jQuery and DataTables are missing (Debian: libjs-jquery-datatables)</p>" + plain_table(rows)
        body += f"<h2>Times and errors</h2><div class=pictures>{histograms(rows)}</div>" if CAN_DRAW else ""
    page = (f"<!DOCTYPE html><html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width'><title>Mesh check</title>"
            f"<style>{CSS}</style></head><body>{body}</body></html>\n")
    write_whole(os.path.join(folder, "report.html"), page)
