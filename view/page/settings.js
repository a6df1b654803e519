// Controls made from the scene and its schema. Ranges and words are the schema's; what is wrong is told by the server.
'use strict';

const SHOWN = {
  'contact.mu': 'Friction μ', 'object.model.young': 'Young [Pa]', 'object.model.damping.mass': 'Damping α [1/s]',
  'object.model.damping.stiffness': 'Damping β [s]', 'local.reducer': 'Reducer', 'local.tolerance': 'Tolerance',
  'global.rate_hz': 'Refreshes [1/s]', 'tool.radius': 'Tool radius [m]', 'contact.surface': 'Contact surface',
  'object.model.type': 'Model', 'object.model.material': 'Material', 'object.tetrahedralize.max_volume': 'Largest tet [m³]'};

class SettingsPanel {
  // change(key, value, isLive): the user has chosen
  constructor(box, keys, change) { Object.assign(this, {box, keys, change, inputs: new Map()}); }

  static at(object, path) { return path.split('.').reduce((o, k) => (o && typeof o === 'object' ? o[k] : undefined), object); }

  rule(schema, key) {
    let rules = schema;
    for (const k of key.split('.')) {
      if (rules.$ref) rules = rules.$ref.slice(2).split('/').reduce((o, p) => o[p], schema);
      rules = (rules.properties || {})[k] || {};
    }
    return rules;
  }

  *paths(object, before = '') {
    for (const [k, v] of Object.entries(object)) {
      const key = before ? before + '.' + k : k;
      if (v && typeof v === 'object' && !Array.isArray(v)) yield* this.paths(v, key);
      else yield key;
    }
  }

  show(hello) {
    this.box.textContent = '';
    this.inputs.clear();
    this.keys.textContent = '';
    for (const key of this.paths(hello.scene)) this.keys.appendChild(new Option(key + '='));
    for (const [key, name] of Object.entries(SHOWN)) {
      const value = key === 'contact.mu' ? hello.mu[0] : SettingsPanel.at(hello.scene, key), words = hello.words[key];
      if (value === undefined || value === null || (key.endsWith('material') && hello.scene.object.model.type !== 'fem')) continue;
      this.add(key, name, value, words, this.rule(hello.schema, key), hello.live.includes(key));
    }
  }

  add(key, name, value, words, rules, isLive) {
    const row = document.createElement('label'), title = document.createElement('span');
    row.className = 'control';
    title.className = 'name';
    title.textContent = name;
    title.title = `${key}: ${rules.description || ''}${isLive ? '' : ' (builds the body anew)'}`;
    if (!isLive) title.textContent += ' ⟳';
    row.appendChild(title);
    if (words) {
      const select = document.createElement('select');
      for (const word of words) select.appendChild(new Option(word, word, false, word === value));
      select.addEventListener('change', () => this.change(key, select.value, isLive));
      row.appendChild(select);
      this.inputs.set(key, {set: v => { if (document.activeElement !== select) select.value = v; }});
    } else {
      const slider = document.createElement('input'), number = document.createElement('input');
      const isRatio = !(key === 'contact.mu');
      // A tenth to ten times the scene's value; friction from none to 1.5.
      Object.assign(slider, isRatio ? {type: 'range', min: -1, max: 1, step: 0.01} : {type: 'range', min: 0, max: 1.5, step: 0.01});
      const base = value > 0 ? value : 1, toValue = s => isRatio ? +(base * 10 ** s).toPrecision(3) : s, toSlider = v => isRatio ? Math.log10(Math.max(v, 1e-12) / base) : v;
      Object.assign(number, {type: 'text', inputMode: 'decimal', value: String(+(+value).toPrecision(6))});
      slider.value = toSlider(value);
      slider.setAttribute('aria-label', name);
      slider.addEventListener('input', () => { number.value = toValue(+slider.value); });
      slider.addEventListener('change', () => this.change(key, number.value, isLive));
      number.addEventListener('change', () => this.change(key, number.value.trim(), isLive));
      row.append(slider, number);
      this.inputs.set(key, {set: v => {
        if (document.activeElement === slider || document.activeElement === number) return;
        number.value = String(+(+v).toPrecision(6));
        slider.value = toSlider(+v);
      }});
    }
    this.box.appendChild(row);
  }

  // What the run has now.
  update(settings) {
    for (const [key, value] of Object.entries(settings)) if (value !== '' && this.inputs.has(key)) this.inputs.get(key).set(value);
  }
}
