// Reads what the server sends as bytes (view/frame_bytes.hpp): little-endian, fields one after another.
'use strict';

class Reader {
  constructor(buffer) { this.view = new DataView(buffer); this.buffer = buffer; this.at = 0; }
  u32() { const v = this.view.getUint32(this.at, true); this.at += 4; return v; }
  f32() { const v = this.view.getFloat32(this.at, true); this.at += 4; return v; }
  f64() { const v = this.view.getFloat64(this.at, true); this.at += 8; return v; }
  floats(n) { const v = new Float32Array(this.buffer, this.at, n); this.at += 4 * n; return v; }
  uints(n) { const v = new Uint32Array(this.buffer, this.at, n); this.at += 4 * n; return v; }
  shorts(n) { const v = new Uint16Array(this.buffer, this.at, n); this.at += 2 * n; return v; }
}

function readTicks(r) {
  const n = r.u32(), values = r.floats(3 * n);
  return {n, values};  // f_n, f_t, mode of each
}

function readMessage(buffer) {
  const r = new Reader(buffer);
  const type = r.u32();
  if (type === 1) {
    const f = {type: 'frame', echo: r.u32(), stamp: r.f64(), t: r.f64(), refreshes: r.u32(), target: r.floats(3), tools: []};
    const tools = r.u32();
    for (let k = 0; k < tools; ++k)
      f.tools.push({x: r.floats(3), r: r.floats(4), force: r.floats(3), normal: r.floats(3), point: r.floats(3),
                    f_n: r.f32(), f_t: r.f32(), mode: r.u32(), flags: r.u32()});
    f.ticks = readTicks(r);
    f.least = r.floats(3);
    f.step = r.floats(3);
    f.positions = r.shorts(r.u32());
    return f;
  }
  if (type === 2) {
    const nodes = r.u32(), x = r.floats(3 * nodes), triangles = r.u32();
    return {type: 'body', x, triangles: r.uints(3 * triangles), fixed: r.uints(r.u32())};
  }
  if (type === 3) {
    const refreshes = r.u32(), triangles = r.uints(r.u32()), nodes = r.u32();
    const refresh = {type: 'refresh', refreshes, triangles, nodes: r.uints(nodes), distance: r.floats(nodes), refined: []};
    for (let n = r.u32(); n > 0; --n) refresh.refined.push({triangle: r.u32(), b: r.f32(), c: r.f32()});
    refresh.edges = r.uints(2 * r.u32());
    return refresh;
  }
  if (type === 4) {
    const h = r.f64();
    return {type: 'trace', h, ticks: readTicks(r)};
  }
  throw new Error('unknown message type ' + type);
}

// Quantized positions as numbers [m], into `out`.
function unpackPositions(frame, out) {
  const {positions, least, step} = frame;
  for (let i = 0; i < positions.length; i += 3) {
    out[i] = least[0] + step[0] * positions[i];
    out[i + 1] = least[1] + step[1] * positions[i + 1];
    out[i + 2] = least[2] + step[2] * positions[i + 2];
  }
}
