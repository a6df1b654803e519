// Force over time, at the tick's resolution: every pixel column shows the least and the largest value of its ticks.
'use strict';

class ForcePlot {
  // seconds: shown at once of a live run. A session is shown whole: setTrace().
  constructor(canvas, seconds = 5) {
    this.canvas = canvas;
    this.seconds = seconds;
    this.mu = [0.5, 0.5];
    this.clear(1e-3);
    this.onSeek = null;
    const seek = e => {
      if (!this.onSeek || !(e.buttons & 1)) return;
      const box = canvas.getBoundingClientRect();
      this.onSeek(Math.min(1, Math.max(0, (e.clientX - box.left - this.left) / (box.width - this.left))) * this.end);
    };
    canvas.addEventListener('pointerdown', seek);
    canvas.addEventListener('pointermove', seek);
    this.left = 38;
  }

  clear(h) {
    this.h = h;
    this.room = Math.max(10, Math.round(this.seconds / h));
    this.values = new Float32Array(3 * this.room);
    this.count = 0;  // of all ticks so far; the last `room` are kept
    this.cursor = null;
    this.end = this.seconds;
    this.scale = new HeldScale(0.05);
  }

  setTrace(h, ticks) {
    this.seconds = ticks.n * h;
    this.clear(h);
    this.room = ticks.n;
    this.values = Float32Array.from(ticks.values);
    this.count = ticks.n;
    this.end = ticks.n * h;
    this.cursor = 0;
  }

  // t: of the last of them [s]; ticks that are missing before leave a gap.
  add(t, ticks) {
    const last = Math.round(t / this.h);
    if (last < this.count) this.clear(this.h);  // a new run
    if (this.count > 0 && last - ticks.n > this.count) {
      const gap = Math.min(this.room, last - ticks.n - this.count);
      for (let i = 0; i < gap; ++i) this.values.fill(NaN, 3 * ((this.count + i) % this.room), 3 * ((this.count + i) % this.room) + 3);
    }
    this.count = last - ticks.n;
    for (let i = 0; i < ticks.n; ++i, ++this.count) this.values.set(ticks.values.subarray(3 * i, 3 * i + 3), 3 * (this.count % this.room));
  }

  draw() {
    const {canvas} = this, ratio = window.devicePixelRatio || 1, w = Math.round(canvas.clientWidth * ratio), h = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const g = canvas.getContext('2d'), style = getComputedStyle(document.documentElement), colour = name => style.getPropertyValue(name).trim();
    const left = this.left * ratio, bottom = 26 * ratio, strip = 8 * ratio, width = w - left, above = 8 * ratio, height = h - bottom - strip - 4 * ratio;
    g.clearRect(0, 0, w, h);
    const first = this.cursor === null ? this.count - this.room : 0;
    const least = [new Float32Array(width), new Float32Array(width)], most = [new Float32Array(width), new Float32Array(width)];
    const modes = new Uint8Array(width).fill(255);
    for (let k = 0; k < 2; ++k) { least[k].fill(Infinity); most[k].fill(-Infinity); }
    let top = 0;
    for (let i = Math.max(0, first); i < this.count; ++i) {
      const at = 3 * (i % this.room), px = Math.min(width - 1, Math.floor((i - first) / this.room * width));
      for (let k = 0; k < 2; ++k) {
        const v = this.values[at + k];
        if (v !== v) continue;
        if (v < least[k][px]) least[k][px] = v;
        if (v > most[k][px]) most[k][px] = v;
        if (v > top) top = v;
      }
      modes[px] = this.values[at + 2];
    }
    this.top = this.scale.hold(1.05 * top, performance.now() / 1000);
    const y = v => height + 2 * ratio - v / this.top * (height - above);
    // Axes.
    g.font = `${11 * ratio}px system-ui, sans-serif`;
    g.fillStyle = colour('--faint');
    g.strokeStyle = colour('--line');
    g.lineWidth = ratio;
    const nice = s => { const p = 10 ** Math.floor(Math.log10(s)); return [1, 2, 5, 10].map(f => f * p).find(v => v >= s); };
    const stepY = nice(this.top / 4);
    g.textAlign = 'right';
    for (let v = 0; v <= this.top; v += stepY) {
      g.beginPath(); g.moveTo(left, y(v)); g.lineTo(w, y(v)); g.stroke();
      g.fillText(String(+v.toPrecision(3)), left - 5 * ratio, y(v) + 4 * ratio);
    }
    g.textAlign = 'center';
    const stepX = nice(this.seconds / 5), from = this.cursor === null ? -this.seconds : 0;
    for (let t = Math.ceil(from / stepX) * stepX; t <= from + this.seconds + 1e-9; t += stepX) {
      const px = left + (t - from) / this.seconds * width;
      g.fillText(`${+t.toPrecision(3)}${Math.abs(t) < 1e-9 && from < 0 ? ' s' : ''}`, Math.min(w - 12 * ratio, Math.max(left + 6 * ratio, px)), h - 4 * ratio);
    }
    g.textAlign = 'right';
    // Sticks or slips, below.
    const band = {1: colour('--stick'), 2: colour('--slide'), 3: colour('--frictional_slide')};
    for (let px = 0; px < width; ++px)
      if (band[modes[px]]) { g.fillStyle = band[modes[px]]; g.fillRect(left + px, height + 4 * ratio, 1, strip); }
    const curve = (k, stroke, factor, dash, lineWidth) => {
      g.strokeStyle = stroke; g.lineWidth = lineWidth * ratio; g.setLineDash(dash);
      g.beginPath();
      let open = false;
      for (let px = 0; px < width; ++px) {
        if (most[k][px] < 0) { open = open && px % 4 !== 0 && dash.length > 0; continue; }
        const a = y(factor * most[k][px]), b = y(factor * least[k][px]);
        open ? g.lineTo(left + px, a) : g.moveTo(left + px, a);
        if (Math.abs(a - b) > 0.5 && !dash.length) g.lineTo(left + px, b);
        open = true;
      }
      g.stroke(); g.setLineDash([]);
    };
    curve(0, colour('--limit'), this.mu[0], [4 * ratio, 3 * ratio], 1);
    curve(1, colour('--tangential'), 1, [], 1.5);
    curve(0, colour('--normal'), 1, [], 1.5);
    if (this.cursor !== null) {
      const px = left + this.cursor / this.end * width;
      g.strokeStyle = colour('--ink'); g.lineWidth = 1.5 * ratio;
      g.beginPath(); g.moveTo(px, 0); g.lineTo(px, height + strip + 4 * ratio); g.stroke();
    }
  }
}
