// Plays a run: the body's frames, linear in between, the tools at their ticks. Its time is the charts' time.
'use strict';
const unpackPositions = (frame, out) => out.set(frame.positions);  // body_view.js asks for it
(() => {
const data = JSON.parse(document.getElementById('player-data').textContent), byId = id => document.getElementById(id);
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
const positions = text => Float32Array.from(new Uint16Array(bytes(text)), (v, i) => data.low[i % 3] + data.step * v);
const send = t => window.dispatchEvent(new CustomEvent('kilotouch-time', {detail: {t, source: 'player'}}));
const before = (times, t) => { let low = 0, high = times.length - 1; while (low < high) { const middle = (low + high + 1) >> 1; if (times[middle] <= t + 1e-9) low = middle; else high = middle - 1; } return low; };
const box = byId('view');


function start() {
  const rest = positions(data.rest), frames = data.x.map(positions), x = new Float32Array(rest.length);
  const tools = data.tools.map(tool => ({...tool, samples: new Float32Array(bytes(tool.samples))}));
  for (const tool of tools) tool.times = Float32Array.from({length: tool.samples.length / 15}, (_, i) => tool.samples[15 * i]);
  let most = 0;
  for (const frame of frames) for (let i = 0; i < frame.length; i += 3) most = Math.max(most, Math.hypot(frame[i] - rest[i], frame[i + 1] - rest[i + 1], frame[i + 2] - rest[i + 2]));
  const view = new BodyView(box);
  if (!view.renderer) throw new Error('no WebGL');
  const triangles = new Uint32Array(bytes(data.triangles));
  const largest = Math.max(...tools.map(tool => tool.largest_force));
  view.metresPerNewton = () => 0.33 * view.size / largest;  // the longest arrow is in the picture
  view.setBody({x: rest, triangles, fixed: data.fixed}, !data.flat);
  view.fixedScale = most;  // one scale for all times
  view.setTools(tools);
  view.camera.position.copy(view.controls.target).addScaledVector(new THREE.Vector3(...data.direction), view.size * 1.9 / Math.min(1, 0.8 * view.camera.aspect));
  view.controls.update();
  byId('scale').textContent = `Colours run from rest to ${+(1e3 * most).toPrecision(3)} mm.`;
  const draw = () => { view.draw(); requestAnimationFrame(draw); };
  requestAnimationFrame(draw);
  let now = data.start, playing = 0;

  function show(t) {
    now = t;
    const i = before(data.t, t), j = Math.min(i + 1, frames.length - 1), share = j > i ? Math.min(1, Math.max(0, (t - data.t[i]) / (data.t[j] - data.t[i]))) : 0;
    // Before the first frame the body is where it rests.
    const a = t < data.t[0] ? rest : frames[i], b = t < data.t[0] ? rest : frames[j];
    for (let k = 0; k < x.length; ++k) x[k] = a[k] + share * (b[k] - a[k]);
    const shown = tools.map(tool => {
      const s = tool.samples.subarray(15 * before(tool.times, t)), place = s.slice(1, 4), normal = s.slice(7, 10), turn = [s[12], s[13], s[14], s[11]];
      const reach = normal.some(c => c !== 0) ? view.support(tool, turn, new THREE.Vector3(...normal)) : 0;
      return {x: place, r: turn, force: s.slice(4, 7), normal, mode: s[10], point: place.map((c, k) => c - reach * normal[k])};
    });
    view.update({positions: x, tools: shown});
    byId('time').value = 1000 * (t - data.start) / (data.end - data.start);
  }
  window.addEventListener('kilotouch-time', ({detail: {t, source}}) => { if (source !== 'player') play(false); show(t); });
  function play(on) {
    box.classList.toggle('plays', on);
    byId('play').textContent = on ? '❚❚ pause' : '▶ play';
    const id = ++playing;
    if (!on) return;
    let last = performance.now();
    const step = stamp => {
      if (id !== playing) return;
      const t = now + Math.min(0.1, Math.max(0, (stamp - last) / 1000)) * byId('speed').value;
      last = stamp;
      if (t >= data.end) { send(data.end); return play(false); }
      send(t);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
  byId('play').addEventListener('click', () => { if (!box.classList.contains('plays') && now >= data.end - 1e-9) now = data.start; play(!box.classList.contains('plays')); });
  byId('time').addEventListener('input', e => { play(false); send(data.start + e.target.value / 1000 * (data.end - data.start)); });
  byId('colour').addEventListener('change', e => { view.setColour(e.target.value); byId('modes').hidden = e.target.value !== 'mode'; byId('scale').hidden = e.target.value !== 'displacement'; show(now); });
  send(data.start + 0.6 * (data.end - data.start));
}
try {
  start();
} catch (error) {  // no WebGL: the still picture
  console.error(error);
  for (const child of [...box.children]) child.hidden = !child.classList.contains('still');
  byId('play').closest('.tools').hidden = true;
}
})();
