// The table of kilotouch check: verdicts, numbers, and the stages of a mesh when its row is opened.
'use strict';
const meshes = JSON.parse(document.getElementById('rows').textContent), byId = id => document.getElementById(id);
const finite = v => typeof v === 'number' && isFinite(v), order = {fail: 0, degraded: 1, pass: 2};
const tag = verdict => element('span', verdict, 'tag ' + (verdict in order || verdict === 'skipped' ? verdict : ''));
function image(source, words) {
  if (!/^data:image\/png;base64,[A-Za-z0-9+/=]+$/.test(source)) return '';
  const out = element('img');
  out.alt = words;
  out.src = source;
  return out;
}
function detail(row) {
  const out = element('div', undefined, 'stages'), table = element('table');
  for (const [name, verdict, why, where, figures] of [...(row.told ? [['real time', '', row.told, null, '']] : []), ...row.stages]) {
    const tr = table.insertRow(), place = where ? ` at (${where.map(c => finite(c) ? +c.toPrecision(6) : 'NaN').join(', ')})` : '';
    tr.append(element('td', name), element('td'), element('td', why + place), element('td'));
    if (verdict) tr.cells[1].append(tag(verdict));
    tr.cells[3].append(element('pre', figures));
  }
  out.append(image(row.large, 'where it failed'), table);
  return out;
}
const number = (title, key, digits, factor, hint) => ({title, hint, cls: 'number', value: row => row[key], text: row => finite(row[key]) ? String(+(row[key] * (factor || 1)).toPrecision(digits)) : '–'});
const words = (title, key, cls, hint) => ({title, hint, cls, text: row => row[key] || (key === 'pace' ? '–' : '')});
const columns = [
  {title: '', fixed: true, fill: (cell, row) => cell.append(image(row.picture, ''))},
  words('mesh', 'path', 'path'),
  {title: 'verdict', value: row => order[row.verdict] ?? 3, text: row => row.verdict, fill: (cell, row) => cell.append(tag(row.verdict))},
  words('stage', 'stage', '', 'the first that is as bad as the verdict'),
  {title: 'why', cls: 'why', text: row => row.why, fill: (cell, row) => { cell.textContent = row.why.length > 160 ? row.why.slice(0, 160) + ' …' : row.why; }},
  number('triangles', 'triangles', 7),
  number('moved %', 'moved', 2, 100, 'how far repair, decimation or wrapping moved the surface, of its size'),
  number('certified %', 'error', 2, 100, "largest certified error of a local model's impedance"),
  number('force %', 'off', 2, 100, 'force of a press against the whole nonlinear body along the same path, larger of both models'),
  number('buzz %', 'buzz', 2, 100, 'force above 100 Hz over the mean, while dragged'),
  number('step µs', 'step_us', 3, 1, '99 of 100 haptic ticks take less'),
  number('refresh ms', 'refresh_ms', 3, 1, 'median time to a new local model'),
  words('real time', 'pace', '', 'does the slower body keep up with 30 refreshes a second here?'),
  number('CPU s', 'cpu_s', 3, 1, 'of the whole check')];
let verdict = '', stage = '';
meshes.sort((a, b) => a.path < b.path ? -1 : a.path > b.path ? 1 : 0);
const table = makeTable(byId('table'), columns, meshes, {order: [2, false], page: 50, search: byId('search'), count: byId('count'), detail,
  keep: row => (!verdict || row.verdict === verdict) && (!stage || row.stage === stage)});
for (const button of document.querySelectorAll('button[data-verdict]')) button.addEventListener('click', () => {
  document.querySelectorAll('button[data-verdict]').forEach(other => other.classList.toggle('on', other === button));
  verdict = button.dataset.verdict;
  table.draw();
});
byId('stage').addEventListener('change', () => { stage = byId('stage').value; table.draw(); });
