// The page: a socket to the server, and what it says shown.
'use strict';

const element = id => document.getElementById(id);
const view = new BodyView(element('view'));
const plot = new ForcePlot(element('plot'));
const state = {hello: null, status: null, time: 0, isPlaying: false, number: 0, shown: 0, lag: [], frames: 0, askedAt: 0};
window.kilotouch = {view, plot, state};  // for tests
element('blind').hidden = Boolean(view.renderer);
element('picture').disabled = !view.renderer;

let socket = null;
function send(message) { if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); }

function tell(text, isBad) {
  const box = element('message');
  box.textContent = text;
  box.className = isBad ? 'bad' : '';
  box.hidden = !text;
  clearTimeout(tell.timer);
  if (text && !isBad) tell.timer = setTimeout(() => { box.hidden = true; }, 8000);
}

// Stays until the body is there, and may be given up: a mesher can take minutes.
function tellBuilding(text) {
  tell(text);
  clearTimeout(tell.timer);
  const button = element('message').appendChild(Object.assign(document.createElement('button'), {id: 'cancel', textContent: 'Cancel'}));
  button.addEventListener('click', () => { button.disabled = true; send({type: 'cancel'}); });
}

// Beside the page, whatever name, port or path a proxy has given it.
function addressOf(name, query = {}) {
  const token = new URLSearchParams(location.search).get('token'), url = new URL(name, location.href);
  for (const [key, value] of Object.entries(token ? {...query, token} : query)) url.searchParams.set(key, value);
  return url;
}

function ask(question) {
  element('question').textContent = question;
  return new Promise(resolve => {
    const dialog = element('ask');
    dialog.onclose = () => resolve(dialog.returnValue === 'yes');
    dialog.returnValue = 'no';
    dialog.showModal();
  });
}

// Pointer places: at most one a frame, the newest.
let wanted = null;
const pointer = new ToolPointer(view, x => { wanted = x; }, () => +element('depth').value / 1000, by => {
  element('depth').value = +element('depth').value + 1000 * by;
  tellDepth();
});
function tellDepth() { element('depth_told').textContent = (+element('depth').value).toFixed(1) + ' mm'; }
element('depth').addEventListener('input', tellDepth);

// What the server says to a setting that asks for a new body: an error text, empty where it would do.
function check(setting) {
  send({type: 'check', settings: [setting]});
  return new Promise(resolve => { state.checked = resolve; });
}

async function change(key, value, isLive) {
  const setting = `${key}=${value}`;
  if (isLive) return send({type: 'set', settings: [setting]});
  const error = await check(setting);
  if (error) tell(error, true);
  else if (await ask(`${key} cannot change while the body is touched. Build the body anew with ${setting}? The other settings stay.`)) {
    tellBuilding('building the body … ');
    return send({type: 'restart', settings: [setting]});
  }
  if (state.hello) settings.show(state.hello);
}
const settings = new SettingsPanel(element('controls'), element('keys'), change);

function list(box, rows) {
  if (box.children.length !== 2 * rows.length) {
    box.textContent = '';
    for (let i = 0; i < rows.length; ++i) box.append(document.createElement('dt'), document.createElement('dd'));
  }
  rows.forEach(([name, value, isBad, isWide], i) => {
    box.children[2 * i].textContent = name;
    box.children[2 * i + 1].textContent = value;
    box.children[2 * i + 1].className = (isBad ? 'bad' : '') + (isWide ? ' wide' : '');
  });
}

const FLAGS = [[2, 'the tool is at the edge of the patch'], [16, 'the local model broke down: force 0'], [64, 'the body is being pushed off the tool'],
               [128, 'the local model is old'], [256, "the body's simulation has ended"], [1024, 'a pose was not usable'],
               [4096, 'the gate is not open: the hand is given less than this'], [8192, 'held back from changing too fast'],
               [16384, "the device's pose is too old"], [65536, 'the tool is beside the refined cells: the force is that of larger ones']];

function showHello(hello) {
  state.hello = hello;
  state.status = null;
  document.body.classList.toggle('session', hello.mode === 'session');
  element('title').textContent = hello.title || hello.scene.object.mesh.split('/').pop();
  document.title = `${element('title').textContent} · kilotouch`;
  plot.seconds = 5;
  plot.clear(hello.h);
  plot.mu = hello.mu;
  element('scenes').textContent = '';
  element('scenes').appendChild(new Option('choose …', ''));
  for (const name of hello.scenes) element('scenes').appendChild(new Option(name.replace(/_/g, ' '), name));
  if (hello.mode === 'session') {
    showChip('good', `recorded, ${hello.duration.toFixed(2)} s`);
    element('sentence').textContent = 'A recorded session, run again. Space plays; the plot and the arrow keys go to a time.';
  }
  settings.show(hello);
  pointer.reset();
  tell('');
}

function showBody(body) {
  view.setBody(body, state.hello.smooth);
  view.setTools(state.hello.tools);
  element('depth').max = Math.max(1, Math.round(100 * view.size));
  element('depth').step = view.size > 0.05 ? 0.1 : 0.01;
  element('depth').value = 25 * view.size;
  tellDepth();
}

function showChip(look, word) {
  element('chip').className = look;
  element('word').textContent = word;
}

// Three states: it keeps up, it is late, it stands still. Before it runs and while it is paused there is none to tell.
function chipOf(s) {
  if (s.error) return ['stopped', 'stands still'];
  if (s.paused) return ['wait', 'paused'];
  if (s.refreshes < 3) return ['wait', 'starting …'];
  if (s.real_time !== 'no') return ['good', 'real time'];
  return ['late', s.refresh_hz < 0.95 * s.wanted_hz ? `late: ${s.refresh_hz.toFixed(0)} of ${s.wanted_hz} refreshes a second` : 'slower than real time'];
}

// Nothing is recorded before the clock runs: the body is brought to rest first.
function showRecording(s) {
  const clip = element('clip'), runs = s.recorded_s !== null;
  clip.hidden = !s.recording;
  clip.className = runs ? 'runs' : '';
  clip.textContent = runs ? `recording ${s.recorded_s.toFixed(1)} s` : 'recording starts: the body comes to rest …';
  element('record').textContent = s.recording ? runs ? 'Stop, save' : 'Cancel' : 'Record';
  element('record').classList.toggle('on', s.recording);
}

function showStatus(s) {
  state.status = s;
  const isSlow = s.real_time === 'no';
  showChip(...chipOf(s));
  element('sentence').textContent = s.error ? `${s.error}. Reset begins anew.`
    : s.refreshes < 3 ? 'The first local model is made.' : `Real time: ${s.real_time_told.replace(': ', ' – ')}.`;
  const percent = v => v === null ? 'unknown' : (100 * v).toFixed(1) + ' %';
  list(element('rates'), [
    ['refreshes a second', `${s.refresh_hz.toFixed(1)} of ${s.wanted_hz}`, isSlow], ['a refresh takes', s.refresh_ms.toFixed(1) + ' ms'],
    ['model age at its adoption', s.late_ticks + ' ticks'], ['reducer', s.reducer], ['coordinates', s.dof], ['patch', s.patch_vertices + ' vertices'],
    ['cells under the tool', s.fineness === null ? 'as they are' : `refined, ${s.fineness.toFixed(2)} of the contact radius`],
    ["force over the continuum's, expected" + (s.fineness === null ? ', light press' : ''), s.force_factor === null ? 'not known' : s.force_factor.toFixed(2), Math.abs(Math.log(s.force_factor ?? 1)) > 0.22],
    ['force error, local model alone', percent(s.expected_force_error), s.expected_force_error > 0.08], ['its worst case, 0–500 Hz', percent(s.certified_error)],
    ['tick, median / 99 %', `${s.tick_p50_us.toFixed(0)} / ${s.tick_p99_us.toFixed(0)} µs`], ['ticks over their period', `${s.misses} of ${s.ticks}`, s.misses > 0],
    ...(s.gate ? [['the device\'s gate', s.gate, s.gate !== 'open']] : []), ['allocations in ticks', s.allocations, s.allocations > 0], ['pages', s.pages], ['pointer to picture', state.lag.length ? state.lag[state.lag.length >> 1].toFixed(0) + ' ms' : '–']]);
  pointer.mayMove = s.has_tool && state.hello.by_pointer;
  element('take').hidden = s.has_tool || !state.hello.by_pointer;
  for (const id of ['pause', 'reset', 'record', 'lift']) element(id).disabled = !s.has_tool;
  element('pause').textContent = s.paused ? 'Go on' : 'Pause';
  showRecording(s);
  settings.update(s.settings);
  if (s.settings['tool.radius']) view.setRadius(+s.settings['tool.radius']);
  if (s.settings['contact.mu']) plot.mu = [+s.settings['contact.mu_static'], +s.settings['contact.mu_kinetic']];
}

function showAnswer(a) {
  if (a.to === 'check') {
    const checked = state.checked;
    state.checked = null;
    if (checked) checked(a.error);
    return;
  }
  if (a.error) return tell(a.error, true);
  if (a.to === 'record') {
    const box = element('message');
    tell(`recorded in ${a.what}; play it with: kilotouch view ${a.what}`);
    clearTimeout(tell.timer);
  } else if (a.to === 'set') tell(`${a.what}: from the next refresh on`);
  else if (a.to === 'restart' || a.to === 'open') tell('');
}

function showFrame(frame) {
  state.next = frame;
  if (state.hello.mode === 'live') plot.add(frame.t, frame.ticks);
}

function connect() {
  const url = addressOf('live');
  url.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  let isOpen = false;
  socket = new WebSocket(url);
  socket.onopen = () => { isOpen = true; };
  socket.binaryType = 'arraybuffer';
  socket.onmessage = event => {
    if (typeof event.data === 'string') {
      const m = JSON.parse(event.data);
      ({hello: showHello, status: showStatus, answer: showAnswer}[m.type] || (() => {}))(m);
      return;
    }
    const m = readMessage(event.data);
    if (m.type === 'body') showBody(m);
    else if (m.type === 'frame') showFrame(m);
    else if (m.type === 'refresh') view.setRefresh(m);
    else if (m.type === 'trace') { plot.setTrace(m.h, m.ticks); state.duration = m.h * m.ticks.n; element('time').max = state.duration; }
  };
  socket.onclose = async event => {
    const why = event.reason || await whyNot(isOpen);
    showChip('stopped', 'no connection');
    element('sentence').textContent = why + ' Trying again …';
    if (event.reason || why.includes('token')) tell(why, true);
    setTimeout(connect, 1000);
  };
}

// A browser does not say why a socket was refused: does the server answer at all?
async function whyNot(wasOpen) {
  if (!wasOpen && (await fetch(addressOf('frame.js')).catch(() => ({}))).ok)
    return 'kilotouch refuses this page: open the whole address that it printed, with its token.';
  return 'No connection to kilotouch.';
}

function showNow(frame) {
  const tool = frame.tools[0], flags = FLAGS.filter(([bit]) => tool.flags & bit).map(([, what]) => what);
  list(element('now'), [['normal', tool.f_n.toFixed(3) + ' N'], ['tangential', tool.f_t.toFixed(3) + ' N'],
                        ['contact', {0: 'none', 1: 'sticks', 2: 'slips, no friction', 3: 'slips'}[tool.mode], false, true],
                        ['state', flags.join('; ') || 'force as computed', flags.length > 0, true]]);
}

function showLegend() {
  const box = element('legend'), c = view.colour;
  if (!view.mesh) return;
  const arrow = `arrow: force, ${+(1000 * view.metresPerNewton()).toPrecision(1)} mm per N`;
  if (!view.ramps[c]) {
    box.innerHTML = c === 'mode' ? '<div><span class="key stick">sticks</span><span class="key slip">slips</span><span class="key slide">slips, no friction</span></div><div></div>' : '<div></div>';
    box.lastChild.textContent = arrow;
    return;
  }
  if (!box.querySelector('.bar') || box.dataset.ramp !== c) {
    box.innerHTML = `<div class="bar" style="background:linear-gradient(to right,${paletteOf(c).split(/\s+/).join(',')})"></div><div class="ends"><span>0</span><span></span></div><div></div>`;
    box.dataset.ramp = c;
  }
  const most = 1000 * view.scale;
  box.querySelector('.ends').lastChild.textContent = most >= 0.1 ? +most.toPrecision(3) + ' mm' : +(1000 * most).toPrecision(3) + ' µm';
  box.lastChild.textContent = `${c === 'error' ? 'local model against body at the last refresh' : 'displacement'}; ${arrow}`;
}

function seek(t) {
  state.time = Math.min(Math.max(t, 0), state.duration || 0);
  element('time').value = state.time;
  element('clock').textContent = state.time.toFixed(3) + ' s';
  plot.cursor = state.time;
  send({type: 'seek', time: state.time});
}
plot.onSeek = t => { if (state.hello && state.hello.mode === 'session') seek(t); };

let last = performance.now(), legendAt = 0, plotAt = 0, shown = null;
function animate(now) {
  requestAnimationFrame(animate);
  const dt = Math.min(0.1, (now - last) / 1000);
  last = now;
  if (!state.hello) return;
  if (state.hello.mode === 'session' && state.isPlaying) {
    let t = state.time + dt * element('speed').value;
    if (t >= state.duration) t = 0;
    seek(t);
  }
  pointer.follow();
  if (wanted) {
    send({type: 'target', x: [wanted.x, wanted.y, wanted.z], number: ++state.number, stamp: performance.now()});
    wanted = null;
  }
  const frame = state.next;
  if (frame && view.mesh && frame.positions.length === view.x.length) {
    state.next = null;
    view.update(frame, {hand: state.hello.mode === 'live' && state.hello.by_pointer});
    shown = frame;
    if (frame.echo > state.shown && state.hello.mode === 'live') {
      state.shown = frame.echo;
      state.lag.push(performance.now() - frame.stamp);
      if (state.lag.length > 400) state.lag.splice(0, 100);
    }
  }
  if (view.draw()) ++state.frames;
  // Numbers and the plot are read, not felt: fewer a second leave the time to the body. A cursor in the plot moves with it.
  if (now > plotAt || (state.hello.mode === 'session' && frame)) { plot.draw(); plotAt = now + (view.isSoftware ? 200 : 50); }
  if (now > legendAt) { showLegend(); if (shown) showNow(shown); legendAt = now + 200; }
}

// Buttons and keys.
const actions = {
  pause: () => send({type: 'pause', on: !(state.status && state.status.paused)}),
  reset: () => { pointer.reset(); send({type: 'reset'}); },
  record: () => { pointer.reset(); send({type: 'record', on: !(state.status && state.status.recording)}); },
  lift: () => pointer.lift(),
  take: () => send({type: 'take'}),
  fit: () => view.fit(),
  picture: () => {
    view.isOld = true;
    if (!view.draw()) return;
    const a = document.createElement('a');
    a.href = view.renderer.domElement.toDataURL('image/png');
    a.download = 'kilotouch.png';
    a.click();
  },
  play: () => { state.isPlaying = !state.isPlaying; element('play').textContent = state.isPlaying ? 'Pause' : 'Play'; }
};
for (const [id, action] of Object.entries(actions)) element(id).addEventListener('click', action);
element('colour').addEventListener('change', () => { element('legend').textContent = ''; view.setColour(element('colour').value); });
element('time').addEventListener('input', () => seek(+element('time').value));
element('other').addEventListener('submit', event => {
  event.preventDefault();
  const text = element('setting').value.trim(), at = text.indexOf('='), key = text.slice(0, at).trim();
  if (at < 1) return tell(`"${text}" must be KEY=VALUE`, true);
  change(key, text.slice(at + 1).trim(), state.hello.live.includes(key));
});
element('scenes').addEventListener('change', () => {
  const name = element('scenes').value;
  if (!name) return;
  tellBuilding('building the body … ');
  send({type: 'open', name});
});
document.addEventListener('keydown', event => {
  if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== 'range') return;
  const isSession = state.hello && state.hello.mode === 'session';
  const steps = {ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, -1], PageDown: [0, 0, 1]};
  if (event.key === ' ') isSession ? actions.play() : actions.pause();
  else if (isSession && steps[event.key]) seek(state.time + 0.01 * (steps[event.key][0] || 10 * steps[event.key][1]));
  else if (steps[event.key] && event.target.type !== 'range') pointer.step(...steps[event.key]);
  else if (event.key === 'r' || event.key === 'R') actions.reset();
  else if (event.key === 'c' || event.key === 'C') actions.record();
  else if (event.key === 'Escape') actions.lift();
  else return;
  event.preventDefault();
});

// A mesh that is dropped: looked at by the doctor first, opened when that is wanted.
async function drop(file) {
  const box = element('findings');
  box.textContent = `looking at ${file.name} …`;
  if (file.size > 64 * 1024 * 1024) { box.textContent = `${file.name}: ${(file.size / 1048576).toFixed(0)} MiB; at most 64 MiB`; return; }
  const answer = await fetch(addressOf('mesh', {name: file.name}), {method: 'POST', body: file}).catch(error => ({error}));
  const found = answer.error ? answer : await answer.json().catch(() => ({error: answer.statusText}));
  if (!answer.ok || found.error) { box.textContent = String(found.error || answer.statusText); return; }
  box.textContent = '';
  const add = (tag, text) => box.appendChild(Object.assign(document.createElement(tag), {textContent: text}));
  add('p', `${file.name}: ${found.nodes} nodes, ${found.triangles} triangles, ${found.tetrahedra} tetrahedra; likely unit ${found.likely_unit}`);
  const ul = add('ul', '');
  for (const [name, count] of Object.entries(found.defects))
    if (count) ul.appendChild(Object.assign(document.createElement('li'), {textContent: `${name.replace(/_/g, ' ')}: ${count}`}));
  const opens = (text, repair) => {
    const button = add('button', text);
    button.addEventListener('click', () => { tellBuilding(repair ? 'repairing the surface, then building the body … ' : 'building the body … '); send({type: 'open', name: 'dropped mesh', repair}); });
    return button;
  };
  opens(found.needs_repair ? 'Repair and touch' : 'Touch this body', Boolean(found.needs_repair)).className = 'strong';
}
element('file').addEventListener('change', () => { if (element('file').files[0]) drop(element('file').files[0]); });
for (const name of ['dragover', 'drop']) document.addEventListener(name, event => {
  event.preventDefault();
  element('drop').classList.toggle('over', name === 'dragover');
  if (name === 'drop' && event.dataTransfer.files[0]) drop(event.dataTransfer.files[0]);
});

element('timeline').hidden = true;
new MutationObserver(() => { element('timeline').hidden = !document.body.classList.contains('session'); }).observe(document.body, {attributes: true});
connect();
requestAnimationFrame(animate);
