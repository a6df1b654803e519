// A table to sort, search, filter and open. Every cell is text, whatever it holds: nothing is parsed as HTML.
'use strict';
function element(name, text, cls) {
  const out = document.createElement(name);
  if (text !== undefined) out.textContent = text;
  if (cls) out.className = cls;
  return out;
}
// columns: {title, hint, cls, text: row => words, value: row => number or words to sort by, fill: (cell, row), fixed: cannot be sorted}
// options: {order: [column, falling], page: rows at a time, search: input, keep: row => boolean, detail: row => element, cls: row => class}
function makeTable(table, columns, rows, options = {}) {
  const head = table.createTHead().insertRow(), body = table.createTBody(), more = element('button', 'more');
  let [column, falling] = options.order || [-1, false], shown = options.page || Infinity, words = '';
  const value = (row, c) => c.value ? c.value(row) : c.text(row);
  const rank = v => typeof v === 'number' && isFinite(v) ? 0 : v === null || v === undefined || v === '' || typeof v === 'number' ? 2 : 1;
  const compare = (a, b) => rank(a) - rank(b) || (rank(a) === 2 ? 0 : (a < b ? -1 : a > b ? 1 : 0) * (falling ? -1 : 1));
  const heads = columns.map((c, i) => {
    const th = element('th', c.title, (c.cls || '') + (c.fixed ? '' : ' sort'));
    if (c.hint) th.title = c.hint;
    if (!c.fixed) th.addEventListener('click', () => { falling = column === i && !falling; column = i; draw(); });
    head.append(th);
    return th;
  });
  function line(row) {
    const tr = element('tr', undefined, (options.cls ? options.cls(row) : '') + (options.detail ? ' row' : ''));
    for (const c of columns) {
      const td = element('td', c.fill ? undefined : c.text(row), c.cls);
      if (c.fill) c.fill(td, row);
      tr.append(td);
    }
    if (options.detail) tr.addEventListener('click', () => {
      if (tr.nextSibling && tr.nextSibling.isDetail) return tr.nextSibling.remove();
      const opened = element('tr'), cell = element('td');
      opened.isDetail = true;
      cell.colSpan = columns.length;
      cell.append(options.detail(row));
      opened.append(cell);
      tr.after(opened);
    });
    return tr;
  }
  function draw() {
    heads.forEach((th, i) => { th.textContent = columns[i].title + (i === column ? (falling ? ' ▼' : ' ▲') : ''); });
    let chosen = rows.filter(row => (!options.keep || options.keep(row)) && (!words || columns.some(c => c.text && c.text(row).toLowerCase().includes(words))));
    if (column >= 0) chosen = chosen.map((row, i) => [row, i]).sort((a, b) => compare(value(a[0], columns[column]), value(b[0], columns[column])) || a[1] - b[1]).map(a => a[0]);
    body.replaceChildren(...chosen.slice(0, shown).map(line));
    more.hidden = chosen.length <= shown;
    more.textContent = `more (${chosen.length - shown} left)`;
    if (options.count) options.count.textContent = `${Math.min(shown, chosen.length)} of ${chosen.length}` + (chosen.length < rows.length ? ` (${rows.length} in all)` : '');
  }
  more.addEventListener('click', () => { shown += 4 * (options.page || 50); draw(); });
  if (options.search) options.search.addEventListener('input', () => { words = options.search.value.toLowerCase(); draw(); });
  (table.closest('.scroll') || table).after(more);
  draw();
  return {draw, order(i, down) { column = i; falling = down; draw(); }, rows(next) { rows = next; draw(); }};
}
