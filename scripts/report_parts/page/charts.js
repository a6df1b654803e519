// Every <figure class=chart> of the page, from the JSON inside it (report_parts/charts.py). Charts of a group share a time:
// a "kilotouch-time" event on the window moves their cursors, and a press or a hover in one of them sends it.
'use strict';
const colour = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim() || name;
const short = v => v === null || v === undefined || Number.isNaN(v) ? '–' : typeof v === 'number' ? String(+v.toPrecision(3)) : String(v);
function setTime(t, source) { window.dispatchEvent(new CustomEvent('kilotouch-time', {detail: {t, source}})); }

// Shades of the contact's modes behind the lines: [until, {mode: share}].
const bands = {
  id: 'bands',
  beforeDraw(chart) {
    if (!chart.spec) return;  // being made
    const spec = chart.spec, {ctx, chartArea: area, scales: {x}} = chart;
    let from = spec.x.min;
    for (const [until, modes] of spec.bands || []) {
      const left = Math.max(area.left, x.getPixelForValue(from)), right = Math.min(area.right, x.getPixelForValue(until));
      ctx.save();
      for (const [mode, share] of Object.entries(modes)) {
        ctx.globalAlpha = 0.3 * share;  // a tint
        ctx.fillStyle = colour(mode);
        ctx.fillRect(left, area.top, right - left + 0.5, area.bottom - area.top);
      }
      ctx.restore();
      from = until;
    }
  },
  afterDraw(chart) {
    if (!chart.spec) return;
    const {ctx, chartArea: area, scales: {x, y}} = chart;
    for (const mark of chart.spec.marks || []) {
      const upright = 'x' in mark, at = upright ? x.getPixelForValue(mark.x) : y.getPixelForValue(mark.y);
      if (!(upright ? at >= area.left && at <= area.right : at >= area.top && at <= area.bottom)) continue;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = colour(mark.colour);
      ctx.setLineDash(mark.dash || []);
      ctx.lineWidth = 1.4;
      ctx.beginPath();
      ctx.moveTo(upright ? at : area.left, upright ? area.top : at);
      ctx.lineTo(upright ? at : area.right, upright ? area.bottom : at);
      ctx.stroke();
      ctx.font = '12px sans-serif';
      if (mark.words && upright) {
        ctx.translate(at - 4, area.top + 4);
        ctx.rotate(-Math.PI / 2);
        ctx.textAlign = 'right';
        ctx.fillText(mark.words, 0, 0);
      } else if (mark.words) {
        ctx.textAlign = 'right';
        ctx.fillText(mark.words, area.right - 4, at - 4);
      }
      ctx.restore();
    }
  }
};

function dataset(spec, s) {
  const x = s.x || spec.x.values, scatter = s.points || false, ink = colour(s.colour || 'ink');
  return {label: s.label, data: x.map((v, i) => ({x: v, y: s.y[i], note: s.notes && s.notes[i]})), type: 'line', showLine: !scatter, stepped: s.stepped || false,
    borderColor: ink, backgroundColor: scatter ? ink : s.fill ? ink + '55' : 'transparent', borderWidth: s.width || 1.5, borderDash: s.dash || [], pointRadius: s.radius || (scatter ? 4 : 0),
    pointStyle: s.marker || (scatter ? 'circle' : 'line'), pointHitRadius: 4, fill: s.fill ? 'start' : false, spanGaps: false, tension: 0};
}
function axis(a) {
  const out = {type: a.log ? 'logarithmic' : 'linear', grace: a.values || a.log ? undefined : '4%', beginAtZero: !a.values && !a.log, title: {display: true, text: a.title, color: colour('soft')}, grid: {color: colour('faint'), drawTicks: true}, ticks: {color: colour('soft'), maxRotation: 0}};
  if (a.log) out.ticks.callback = v => [1, 2, 5, 10].some(d => Math.abs(v / 10 ** Math.floor(Math.log10(v)) - d) < 1e-6) ? String(+v.toPrecision(3)) : '';
  if (a.whole && !a.log) out.ticks.precision = 0;
  if (a.min !== undefined) out.min = a.min;
  if (a.max !== undefined) out.max = a.max;
  return out;
}
function makeChart(figure, spec) {
  const canvas = figure.querySelector('canvas'), many = spec.series.length > 1;
  if (figure.chart) figure.chart.destroy();
  const chart = new Chart(canvas, {data: {datasets: []}, plugins: [bands], options: {
    maintainAspectRatio: false, animation: false, normalized: true, interaction: {mode: spec.group ? 'index' : 'nearest', intersect: !spec.group, axis: 'xy'},
    plugins: {legend: {display: many || spec.legend === true, position: 'bottom', labels: {color: colour('ink'), usePointStyle: spec.series.some(s => s.points), boxWidth: spec.series.some(s => s.points) ? 10 : 26, boxHeight: spec.series.some(s => s.points) ? 10 : 1, font: {size: 12}}},
      tooltip: {enabled: !spec.group, callbacks: {label: i => i.raw.note ? String(i.raw.note).split('\n') : i.dataset.label + ': ' + short(i.raw.y)}}},
    scales: {x: axis(spec.x), y: {...axis(spec.y), afterFit: scale => { scale.width = spec.group ? 62 : Math.max(scale.width, 50); }}}}});
  chart.spec = spec;
  chart.data.datasets = spec.series.map(s => dataset(spec, s));
  if (many) chart.options.plugins.legend.labels.generateLabels = c => Chart.defaults.plugins.legend.labels.generateLabels(c).map(l => ({...l, lineWidth: Math.max(l.lineWidth, 2)}));
  chart.update();
  figure.chart = chart;
  return chart;
}

// The value of a line at a time: of the sample before it.
function sampleAt(x, t) {
  let low = 0, high = x.length - 1;
  while (low < high) { const middle = (low + high + 1) >> 1; if (x[middle] <= t + 1e-9) low = middle; else high = middle - 1; }
  return low;
}
function bindTime(figure, spec) {
  const plot = figure.querySelector('.plot'), cursor = document.createElement('div'), readout = figure.querySelector('.readout');
  cursor.className = 'cursor';
  plot.append(cursor);
  const timeOf = event => {
    const area = figure.chart.chartArea, x = event.clientX - plot.getBoundingClientRect().left;
    return Math.min(spec.x.max, Math.max(spec.x.min, figure.chart.scales.x.getValueForPixel(Math.min(area.right, Math.max(area.left, x)))));
  };
  const hovers = () => !document.querySelector('.view.plays');
  plot.addEventListener('pointerdown', e => setTime(timeOf(e), 'chart'));
  plot.addEventListener('pointermove', e => { if (e.buttons || hovers()) setTime(timeOf(e), 'chart'); });
  window.addEventListener('kilotouch-time', ({detail: {t}}) => {
    const {chartArea: area, scales: {x}} = figure.chart;
    Object.assign(cursor.style, {display: 'block', top: area.top + 'px', height: area.bottom - area.top + 'px', transform: `translateX(${x.getPixelForValue(t)}px)`});
    if (readout) readout.textContent = `t = ${t.toFixed(3)} s: ` + spec.series.filter(s => s.y.length).map(s => { const at = s.x || spec.x.values; return `${s.label} ${short(s.y[sampleAt(at, t)])}`; }).join(', ') + (spec.unit ? ' ' + spec.unit : '');
  });
}

function drawAll() { for (const figure of document.querySelectorAll('figure.chart')) if (figure.spec) makeChart(figure, figure.spec); }
for (const figure of document.querySelectorAll('figure.chart')) {
  const text = figure.querySelector('script[type="application/json"]');
  if (!text) continue;
  const choices = JSON.parse(text.textContent), select = figure.querySelector('select');  // one spec, or several to choose from
  figure.spec = Array.isArray(choices) ? choices[0] : choices;
  if (select) {
    for (const [i, one] of choices.entries()) { const option = document.createElement('option'); option.value = i; option.textContent = one.title; select.append(option); }
    select.addEventListener('change', () => makeChart(figure, figure.spec = choices[select.value]));
  }
  makeChart(figure, figure.spec);
  if (figure.spec.group) bindTime(figure, figure.spec);
}
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', drawAll);
