// chart.html: which chart, which cost and error, which families; the table follows.
'use strict';
const data = JSON.parse(document.getElementById('data').textContent), byId = id => document.getElementById(id);
const positive = v => typeof v === 'number' && isFinite(v) && v > 0;
const panels = data.charts.flatMap(chart => chart.panels.map(panel => ({...panel, chart})));
const option = (select, value, text) => { const o = element('option', text); o.value = value; select.append(o); };
panels.forEach((p, i) => option(byId('panel'), i, p.chart.title + ' – ' + p.name));
data.axes.forEach(a => option(byId(a.is_cost ? 'cost' : 'error'), a.key, a.title));
const families = [...new Set(panels.flatMap(p => p.points.map(q => q.group)))];
const boxes = new Map(families.map(f => {
  const label = element('label'), box = element('input'), name = element('span', ' ' + f);
  box.type = 'checkbox';
  box.checked = true;
  box.addEventListener('change', draw);
  name.style.cssText = `color: var(--${data.styles[f][0]}); font-weight: 600`;
  label.append(box, name);
  byId('families').append(label);
  return [f, box];
}));
function front(points, x, y) {
  let best = Infinity;
  return [...points].sort((a, b) => a[x] - b[x] || a[y] - b[y]).filter(p => p[y] < best && ((best = p[y]), true));
}
let table = null, best = [];
function draw() {
  const panel = panels[byId('panel').value], x = byId('cost').value, y = byId('error').value, title = key => data.axes.find(a => a.key === key).title;
  const all = panel.points.filter(p => boxes.get(p.group).checked), points = all.filter(p => positive(p[x]) && positive(p[y]));
  byId('truth').textContent = panel.truth;
  for (const [f, box] of boxes) box.parentElement.hidden = !panel.points.some(p => p.group === f);
  const missing = all.length - points.length;
  byId('missing').textContent = missing ? `${missing} of ${all.length} methods are not in the picture: they failed, or their value is zero, which a logarithmic axis cannot show; see the table.` : '';
  best = front(points, x, y);
  const words = p => [`${p.body}, ${p.label}`, `${title(y)}: ${short(p[y])}`, `${title(x)}: ${short(p[x])}`, `dof ${short(p.dof)}, hash ${short(p.hash)}`, ...p.command.replace('kilotouch run ', '').split(' --set ').slice(1)].join('\n');
  const series = families.map(f => points.filter(p => p.group === f)).filter(own => own.length).map(own => ({label: own[0].group, colour: data.styles[own[0].group][0], marker: data.styles[own[0].group][1],
    points: true, radius: own[0].group === 'ours' ? 10 : 6, width: own[0].group === 'ours' || own[0].group === 'baseline' ? 2.5 : 1, x: own.map(p => p[x]), y: own.map(p => p[y]), notes: own.map(words)}));
  series.push({label: 'front: none is faster and more exact', colour: 'grey', stepped: true, x: best.map(p => p[x]), y: best.map(p => p[y])});
  const values = key => points.map(p => p[key]), marks = [];
  if (y === 'force_error') marks.push({y: 100 * data.noticeable, colour: 'vermilion', dash: [6, 4], words: `noticeable: ${100 * data.noticeable} %`});
  if (x.startsWith('tick')) marks.push({x: 1000, colour: 'vermilion', dash: [6, 4], words: '1 ms'});
  if (window.Chart) makeChart(byId('chart'), byId('chart').spec = {series, marks, x: {title: title(x), log: true, min: Math.min(...values(x)) / 1.3, max: Math.max(...values(x), x.startsWith('tick') ? 1000 : 0) * 1.4},
    y: {title: title(y), log: true, min: Math.min(...values(y)) / 1.3, max: Math.max(...values(y)) * 1.5}});
  if (table) return table.rows(all);
  const text = key => p => short(p[key]);
  // Less than a nanometre is rounding: no digit of it means anything.
  const number = (key, name) => ({title: name, cls: 'number', text: p => name.endsWith('[µm]') && p[key] > 0 && p[key] < 1e-3 ? '< 0.001' : short(p[key]), value: p => p[key]});
  const columns = [['label', 'method'], ['body', 'body'], ['group', 'family']].map(([key, name]) => ({title: name, text: text(key)}));
  columns.push(number('dof', 'dof'), ...data.axes.map(a => number(a.key, a.title)), {title: 'real time', text: text('real_time')}, number('lost_contacts', 'contacts lost'), {title: 'trouble', text: text('trouble')},
    {title: 'command', cls: 'command', text: text('command')});
  table = makeTable(byId('table'), columns, all, {order: [4 + data.axes.findIndex(a => a.key === y), false], cls: p => best.includes(p) ? 'front' : ''});
}
for (const id of ['panel', 'cost', 'error']) byId(id).addEventListener('change', draw);
byId('cost').value = 'tick_p50_us';
byId('error').value = 'force_error';
if (panels.length) draw();
