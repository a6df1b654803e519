// The body and the tools in three dimensions. Buffers are made once for a body; an update writes numbers into them.
'use strict';

// palette.css, which the page has in it.
const paletteOf = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const rgbOf = hex => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255);
const rampOf = name => paletteOf(name).split(/\s+/).map(rgbOf);

function colourOf(ramp, share, out) {
  const at = Math.min(1, Math.max(0, share)) * (ramp.length - 1), i = Math.min(ramp.length - 2, Math.floor(at)), s = at - i;
  for (let c = 0; c < 3; ++c) out[c] = (1 - s) * ramp[i][c] + s * ramp[i + 1][c];
}

// The end of a scale, which holds still: it grows at once to a round number, and comes back when less than a third of it
// was needed for five seconds.
class HeldScale {
  constructor(least) { this.least = least; this.clear(); }
  clear() { this.top = 0; this.most = 0; this.quietSince = 0; }
  static round(v) {
    const power = 10 ** Math.floor(Math.log10(v));
    return [1, 2, 5, 10].map(f => f * power).find(r => r >= v * (1 - 1e-9));
  }
  // needed: now; now [s]
  hold(needed, now) {
    const wanted = HeldScale.round(Math.max(needed, this.least));
    if (wanted >= this.top || needed > this.top / 3) {
      this.top = Math.max(this.top, wanted);
      this.quietSince = now;
      this.most = 0;
    } else {
      this.most = Math.max(this.most, wanted);
      if (now - this.quietSince > 5) { this.top = this.most; this.quietSince = now; this.most = 0; }
    }
    return this.top;
  }
}

// Seen before every background: a core in a rim of the opposite lightness.
class Arrow {
  constructor(core, rim) {
    this.object = new THREE.Group();
    this.object.visible = false;
    this.parts = [[rim, 0.45, 10], [core, 0, 11]].filter(([colour]) => colour).map(([colour, more, order]) => {
      const material = new THREE.MeshBasicMaterial({color: colour, depthTest: false, transparent: true});
      const shaft = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 12), material), tip = new THREE.Mesh(new THREE.ConeGeometry(1, 1, 20), material);
      shaft.renderOrder = tip.renderOrder = order;
      this.object.add(shaft, tip);
      return {shaft, tip, more};
    });
  }

  // width: half the shaft's [m]
  show(from, along, length, width) {
    const way = new THREE.Vector3(along[0], along[1], along[2]);
    this.object.visible = length > width && way.lengthSq() > 0;
    if (!this.object.visible) return;
    this.object.position.set(from[0], from[1], from[2]);
    this.object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
    const head = Math.min(0.5 * length, 7 * width);
    for (const {shaft, tip, more} of this.parts) {
      const rim = more * width;
      shaft.scale.set(width + rim, length - head + rim, width + rim);
      shaft.position.y = (length - head) / 2;
      tip.scale.set(2.6 * width + 2 * rim, head + 3 * rim, 2.6 * width + 2 * rim);
      tip.position.y = length - head / 2 + 0.3 * rim;
    }
  }
}

class BodyView {
  // container: an element with a size. Needs THREE and THREE.OrbitControls.
  constructor(container) {
    this.container = container;
    // Where a picture is drawn by the processor, smooth edges cost most of its time, and the body needs that processor too.
    this.isSoftware = BodyView.isDrawnBySoftware();
    // A machine without WebGL has no picture: all else goes on.
    try {
      this.renderer = new THREE.WebGLRenderer({antialias: !this.isSoftware, alpha: true, preserveDrawingBuffer: true});
    } catch (error) {
      this.renderer = null;
    }
    this.surface = this.renderer ? this.renderer.domElement : document.createElement('div');  // that the pointer is on
    this.setSharpness(this.isSoftware ? 0.75 : 1);
    container.appendChild(this.surface);
    this.makeGuide();
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.001, 10);
    this.camera.up.set(0, 0, 1);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x9098a8, 0.62));
    this.lamp = new THREE.DirectionalLight(0xffffff, 0.42);
    this.scene.add(this.lamp);
    this.controls = new THREE.OrbitControls(this.camera, this.surface);
    this.controls.enableKeys = false;
    this.controls.addEventListener('change', () => { this.isOld = true; });
    this.colour = 'displacement';
    this.marks = new THREE.Group();
    this.scene.add(this.marks);
    this.tools = [];
    this.ramps = {displacement: rampOf('displacement'), error: rampOf('error')};
    this.plain = rgbOf(paletteOf('body'));
    this.scale = 0;      // of the colours [m]
    this.fixedScale = 0;  // of a run that is known whole [m]; 0: held()
    this.isOld = true;   // the picture
    this.resize();
    new ResizeObserver(() => this.resize()).observe(container);
  }

  static isDrawnBySoftware() {
    const gl = document.createElement('canvas').getContext('webgl');
    const names = gl && gl.getExtension('WEBGL_debug_renderer_info');
    return Boolean(names) && /swiftshader|llvmpipe|software/i.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL));
  }

  // Every edge has two triangles.
  static isClosed(triangles) {
    const seen = new Map();
    for (let i = 0; i < triangles.length; ++i) {
      const a = triangles[i], b = triangles[i % 3 === 2 ? i - 2 : i + 1], key = Math.min(a, b) * 4294967296 + Math.max(a, b);
      seen.set(key, (seen.get(key) || 0) + 1);
    }
    for (const n of seen.values()) if (n !== 2) return false;
    return true;
  }

  // pixels of the picture to one of the screen
  setSharpness(sharpness) {
    this.sharpness = sharpness;
    if (this.renderer) this.renderer.setPixelRatio(sharpness * Math.min(2, window.devicePixelRatio || 1));
    this.isOld = true;
  }

  resize() {
    const w = Math.max(1, this.container.clientWidth), h = Math.max(1, this.container.clientHeight);
    if (this.renderer) this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.isOld = true;
  }

  // body: {x: Float32Array at rest [m], triangles: Uint32Array, fixed: numbers of the clamped nodes}. smooth: the contact surface is.
  setBody(body, smooth) {
    if (this.mesh) {
      this.scene.remove(this.mesh);
      this.mesh.geometry.dispose();
      this.mesh.material.dispose();
    }
    this.rest = Float32Array.from(body.x);
    this.x = Float32Array.from(body.x);
    this.triangles = body.triangles;
    this.smooth = smooth;
    const geometry = new THREE.BufferGeometry();
    this.position = new THREE.BufferAttribute(this.x, 3);
    this.paint = new THREE.BufferAttribute(new Float32Array(this.x.length), 3);
    geometry.setIndex(new THREE.BufferAttribute(body.triangles, 1));
    geometry.setAttribute('position', this.position);
    geometry.setAttribute('color', this.paint);
    geometry.computeVertexNormals();
    // Backs are drawn of an open surface only: they cost as much as the fronts.
    const look = {vertexColors: THREE.VertexColors, side: BodyView.isClosed(body.triangles) ? THREE.FrontSide : THREE.DoubleSide,
                  polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2};  // lines on it are whole
    const material = smooth ? new THREE.MeshLambertMaterial(look)
                            : new THREE.MeshPhongMaterial({...look, flatShading: true, shininess: 12, specular: 0x0c0c0c});
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.scene.add(this.mesh);
    // The body at rest, for rays: what a tool presses into must not move away from under the pointer.
    const still = new THREE.BufferGeometry();
    still.setIndex(geometry.index);
    still.setAttribute('position', new THREE.BufferAttribute(this.rest, 3));
    still.computeVertexNormals();
    this.still = new THREE.Mesh(still, new THREE.MeshBasicMaterial({side: THREE.FrontSide}));
    still.computeBoundingSphere();
    this.size = 2 * still.boundingSphere.radius;
    this.patch = null;
    this.distance = new Float32Array(body.x.length / 3);
    this.held = {displacement: new HeldScale(1e-3 * this.size), error: new HeldScale(1e-5 * this.size), force: new HeldScale(0.1)};
    this.scale = 0;
    this.makeMarks(body.fixed || []);
    this.fit();
  }

  makeMarks(fixed) {
    while (this.marks.children.length) this.marks.remove(this.marks.children[0]);
    const line = (n, colour, dashed) => {
      const g = new THREE.BufferGeometry();
      g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * n), 3));
      const l = new THREE.LineSegments(g, new THREE.LineBasicMaterial({color: colour, depthTest: !dashed, transparent: true}));
      l.frustumCulled = false;
      this.marks.add(l);
      return l;
    };
    this.outline = this.cells = null;
    this.spring = line(2 * 24, 0x777777, true);
    const ball = (r, colour) => {
      const m = new THREE.Mesh(new THREE.SphereGeometry(r, 16, 12), new THREE.MeshBasicMaterial({color: colour, depthTest: false, transparent: true, opacity: 0.8}));
      this.marks.add(m);
      return m;
    };
    this.cursor = ball(0.006 * this.size, 0x555555);
    this.normals = [0, 1].map(() => new Arrow(paletteOf('limit')));
    this.forces = [0, 1].map(() => new Arrow(paletteOf('force'), paletteOf('force-rim')));
    for (const arrow of [...this.normals, ...this.forces]) this.marks.add(arrow.object);
    this.showClamped(fixed);
    this.contacts = [0, 1].map(() => this.makeContact());
  }

  // Dots on the nodes that are clamped: they stay where they are.
  showClamped(fixed) {
    const g = new THREE.BufferGeometry(), x = new Float32Array(3 * fixed.length);
    fixed.forEach((node, k) => x.set(this.rest.subarray(3 * node, 3 * node + 3), 3 * k));
    g.setAttribute('position', new THREE.BufferAttribute(x, 3));
    this.clamped = new THREE.Points(g, new THREE.PointsMaterial({color: paletteOf('clamped'), size: 3.5, sizeAttenuation: false}));
    this.clamped.frustumCulled = false;
    this.marks.add(this.clamped);
  }

  // The triangles that a tool lies on, seen through the tool.
  makeContact() {
    const g = new THREE.BufferGeometry();
    g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(9 * BodyView.MOST_TOUCHED), 3));
    const mesh = new THREE.Mesh(g, new THREE.MeshBasicMaterial({depthTest: false, transparent: true, opacity: 0.85, side: THREE.DoubleSide}));
    mesh.frustumCulled = false;
    mesh.renderOrder = 5;
    mesh.visible = false;
    this.marks.add(mesh);
    return mesh;
  }

  // tools: [{shape, radius, corners, triangles}], lengths in m.
  setTools(tools) {
    for (const t of this.tools) this.scene.remove(t.object);
    this.tools = tools.map(tool => {
      const material = new THREE.MeshPhongMaterial({color: paletteOf('tool'), shininess: 60, transparent: true, opacity: this.toolOpacity()});
      const object = new THREE.Group();
      const add = (geometry, x) => {
        const m = new THREE.Mesh(geometry, material);
        if (x) m.position.set(x[0], x[1], x[2]);
        object.add(m);
        return m;
      };
      const corners = tool.corners || [];
      if (tool.shape === 'capsule') {
        const [a, b] = corners.map(c => new THREE.Vector3(...c));
        const rod = add(new THREE.CylinderGeometry(tool.radius, tool.radius, a.distanceTo(b), 24, 1, true));
        rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), b.clone().sub(a).normalize());
        rod.position.copy(a.clone().add(b).multiplyScalar(0.5));
        for (const c of corners) add(new THREE.SphereGeometry(tool.radius, 24, 16), c);
      } else if (tool.shape === 'mesh') {
        const g = new THREE.BufferGeometry();
        g.setIndex([].concat(...tool.triangles));
        g.setAttribute('position', new THREE.BufferAttribute(new Float32Array([].concat(...corners)), 3));
        g.computeVertexNormals();
        material.flatShading = true;
        material.side = THREE.DoubleSide;
        add(g);
      } else {
        add(new THREE.SphereGeometry(tool.radius > 0 ? tool.radius : 0.004 * (this.size || 0.1), 32, 24));
      }
      this.scene.add(object);
      return {...tool, object};
    });
  }

  // The radius of a tool changed while it runs.
  setRadius(radius) {
    const tool = this.tools[0];
    if (!tool || tool.shape === 'mesh' || !(radius > 0) || Math.abs(radius - tool.radius) < 1e-9) return;
    this.setTools(this.tools.map((t, k) => k === 0 ? {...t, radius} : t));
  }

  // How far the tool reaches from its reference point against a direction [m].
  support(tool, r, normal) {
    const turn = new THREE.Quaternion(r[0], r[1], r[2], r[3]);
    let most = 0;
    for (const c of tool.corners || []) most = Math.max(most, -new THREE.Vector3(...c).applyQuaternion(turn).dot(normal));
    return most + tool.radius;
  }

  fit() {
    const s = this.still.geometry.boundingSphere, far = 1.25 * s.radius / Math.sin(0.5 * this.camera.fov * Math.PI / 180) /
        Math.min(1, this.camera.aspect);
    this.camera.near = far / 200;
    this.camera.far = 20 * far;
    this.camera.position.set(s.center.x + 0.35 * far, s.center.y - 0.75 * far, s.center.z + 0.55 * far);
    this.controls.target.copy(s.center);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.isOld = true;
  }

  // refresh: {triangles, nodes, distance} of the last one.
  setRefresh(refresh) {
    const count = new Map();
    for (const t of refresh.triangles)
      for (let c = 0; c < 3; ++c) {
        const a = this.triangles[3 * t + c], b = this.triangles[3 * t + (c + 1) % 3], key = Math.min(a, b) * 4294967296 + Math.max(a, b);
        count.set(key, (count.get(key) || 0) + 1);
      }
    const rim = [];
    for (const [key, n] of count) if (n === 1) rim.push(Math.floor(key / 4294967296), key % 4294967296);
    this.rim = rim;
    if (this.outline) this.marks.remove(this.outline);
    const g = new THREE.BufferGeometry();
    g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * rim.length), 3));
    this.outline = new THREE.LineSegments(g, new THREE.LineBasicMaterial({color: paletteOf('force'), transparent: true, opacity: 0.75}));
    this.outline.frustumCulled = false;
    this.marks.add(this.outline);
    this.setRefined(refresh);
    this.patch = new Set(refresh.triangles);
    this.distance.fill(0);
    refresh.nodes.forEach((node, k) => { this.distance[node] = refresh.distance[k]; });
    this.isOld = true;
  }

  // Edges of the refined cells, on the surface as it is drawn: how far they yield beyond it is not sent.
  setRefined(refresh) {
    if (this.cells) {
      this.marks.remove(this.cells);
      this.cells.geometry.dispose();
    }
    this.refined = refresh.refined;
    const g = new THREE.BufferGeometry();
    g.setIndex(new THREE.BufferAttribute(refresh.edges, 1));
    g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * this.refined.length), 3));
    this.cells = new THREE.LineSegments(g, new THREE.LineBasicMaterial({color: paletteOf('force'), transparent: true, opacity: 0.3}));
    this.cells.frustumCulled = false;
    this.marks.add(this.cells);
  }

  placeRefined() {
    const out = this.cells.geometry.attributes.position.array, x = this.x;
    this.refined.forEach(({triangle, b, c}, k) => {
      const [i, j, l] = [0, 1, 2].map(corner => 3 * this.triangles[3 * triangle + corner]);
      for (let d = 0; d < 3; ++d) out[3 * k + d] = (1 - b - c) * x[i + d] + b * x[j + d] + c * x[l + d];
    });
    this.cells.geometry.attributes.position.needsUpdate = true;
  }

  // frame: as readMessage() gives it. options.hand: the tool is held to frame.target by a spring.
  update(frame, options = {}) {
    unpackPositions(frame, this.x);
    this.position.needsUpdate = true;
    if (this.smooth) this.mesh.geometry.computeVertexNormals();
    this.frame = frame;
    const now = performance.now() / 1000;
    frame.tools.forEach((tool, k) => {
      const shown = this.tools[k];
      if (!shown) return;
      shown.object.position.set(tool.x[0], tool.x[1], tool.x[2]);
      shown.object.quaternion.set(tool.r[0], tool.r[1], tool.r[2], tool.r[3]);
      const size = Math.hypot(...tool.force);
      this.held.force.hold(size, now);
      this.forces[k].show(this.arrowStart(shown, tool), tool.force, Math.min(1.5 * this.size, size * this.metresPerNewton()), 0.0035 * this.size);
      this.normals[k].show(tool.point, tool.normal, tool.mode > 0 ? 0.1 * this.size : 0, 0.0015 * this.size);
    });
    this.showSpring(frame, options.hand);
    this.colourIn();
    this.isOld = true;
  }

  // Length of a force arrow: the end of the force's scale is a third of the body's size, in round numbers.
  metresPerNewton() {
    const wanted = 1000 * 0.34 * this.size / Math.max(this.held.force.top, this.held.force.least), power = 10 ** Math.floor(Math.log10(wanted));
    return [5, 2, 1].map(f => f * power).find(v => v <= wanted) / 1000;
  }

  // On the tool's surface: where it touches; without a contact, on the side that the force points to.
  arrowStart(shown, tool) {
    if (tool.mode > 0) return tool.point;
    const way = new THREE.Vector3(...tool.force).normalize();
    return new THREE.Vector3(...tool.x).addScaledVector(way, this.support(shown, tool.r, way.clone().negate())).toArray();
  }

  // A zigzag from the tool to the cursor, as long as the spring is.
  showSpring(frame, hand) {
    this.cursor.visible = this.spring.visible = Boolean(hand);
    if (!hand) return;
    const a = new THREE.Vector3(...frame.tools[0].x), b = new THREE.Vector3(...frame.target), way = b.clone().sub(a), length = way.length();
    this.cursor.position.copy(b);
    this.spring.visible = length > 0.004 * this.size;
    if (!this.spring.visible) return;
    const side = new THREE.Vector3().crossVectors(way, this.camera.getWorldDirection(new THREE.Vector3())).normalize().multiplyScalar(0.012 * this.size);
    const out = this.spring.geometry.attributes.position, n = 24;
    const at = i => {
      const p = a.clone().addScaledVector(way, i / n);
      return i === 0 || i === n ? p : p.addScaledVector(side, i % 2 ? 1 : -1);
    };
    for (let i = 0; i < n; ++i) {
      const p = at(i), q = at(i + 1);
      out.setXYZ(2 * i, p.x, p.y, p.z);
      out.setXYZ(2 * i + 1, q.x, q.y, q.z);
    }
    out.needsUpdate = true;
  }

  colourIn() {
    const paint = this.paint.array, x = this.x, rest = this.rest, c = [0, 0, 0], n = x.length / 3, ramp = this.ramps[this.colour];
    if (ramp) {
      if (!this.values || this.values.length !== n) this.values = new Float32Array(n);
      const v = this.values;
      let most = 0;
      for (let i = 0; i < n; ++i) {
        v[i] = this.colour === 'error' ? this.distance[i] : Math.hypot(x[3 * i] - rest[3 * i], x[3 * i + 1] - rest[3 * i + 1], x[3 * i + 2] - rest[3 * i + 2]);
        if (v[i] > most) most = v[i];
      }
      this.scale = this.colour === 'displacement' && this.fixedScale || this.held[this.colour].hold(most, performance.now() / 1000);
      for (let i = 0; i < n; ++i) {
        colourOf(ramp, v[i] / this.scale, c);
        paint[3 * i] = c[0]; paint[3 * i + 1] = c[1]; paint[3 * i + 2] = c[2];
      }
    } else {
      for (let i = 0; i < n; ++i) paint.set(this.plain, 3 * i);
    }
    this.paint.needsUpdate = true;
    this.contacts.forEach((mesh, k) => this.colourContact(mesh, this.tools[k], this.frame && this.frame.tools[k]));
  }

  // Only what touches sticks or slips: the tool, and the triangles that it lies on.
  colourContact(mesh, shown, tool) {
    const mode = this.colour === 'mode' && shown && tool ? tool.mode : 0, colour = paletteOf(['tool', 'stick', 'slide', 'frictional_slide'][mode]);
    if (shown) shown.object.traverse(part => { if (part.material) part.material.color.set(colour); });
    mesh.visible = mode > 0;
    if (!mesh.visible) return;
    mesh.material.color.set(colour);
    const at = mesh.geometry.attributes.position, touched = this.touched(shown, tool);
    touched.forEach((t, i) => {
      for (let c = 0; c < 3; ++c) {
        const node = this.triangles[3 * t + c];
        at.setXYZ(3 * i + c, this.x[3 * node], this.x[3 * node + 1], this.x[3 * node + 2]);
      }
    });
    mesh.geometry.setDrawRange(0, 3 * touched.length);
    at.needsUpdate = true;
  }

  // Triangles under the tool: the one at the contact point, and those whose three corners lie on the tool's surface.
  touched(shown, tool) {
    const x = this.x, corner = i => new THREE.Vector3(x[3 * i], x[3 * i + 1], x[3 * i + 2]), point = new THREE.Vector3(...tool.point);
    const turn = new THREE.Quaternion(...tool.r), centre = new THREE.Vector3(...tool.x);
    const ends = shown.shape === 'mesh' ? [] : (shown.corners && shown.corners.length ? shown.corners : [[0, 0, 0]]).map(c => new THREE.Vector3(...c).applyQuaternion(turn).add(centre));
    const axis = ends.length && new THREE.Line3(ends[0], ends[ends.length - 1]), on = new THREE.Vector3();
    const isOn = p => axis && shown.radius > 0 && axis.closestPointToPoint(p, true, on).distanceTo(p) < 1.04 * shown.radius;
    const out = [], face = new THREE.Triangle();
    let nearest = -1, least = Infinity;
    const candidates = this.patch || this.triangles.length / 3, each = typeof candidates === 'number' ? f => { for (let t = 0; t < candidates; ++t) f(t); } : f => candidates.forEach(f);
    each(t => {
      face.set(corner(this.triangles[3 * t]), corner(this.triangles[3 * t + 1]), corner(this.triangles[3 * t + 2]));
      const away = face.closestPointToPoint(point, on).distanceTo(point);
      if (away < least) { least = away; nearest = t; }
      if (isOn(face.a) && isOn(face.b) && isOn(face.c) && out.length < BodyView.MOST_TOUCHED - 1) out.push(t);
    });
    if (nearest >= 0 && !out.includes(nearest)) out.push(nearest);
    return out;
  }

  toolOpacity() { return this.colour === 'mode' ? 0.5 : 0.82; }

  setColour(colour) {
    this.colour = colour;
    for (const tool of this.tools) tool.object.traverse(part => { if (part.material) part.material.opacity = this.toolOpacity(); });
    if (this.frame) this.colourIn();
    this.isOld = true;
  }

  draw() {
    if (!this.isOld || !this.mesh) return false;
    if (this.outline) {
      const out = this.outline.geometry.attributes.position.array;
      this.rim.forEach((node, k) => { for (let c = 0; c < 3; ++c) out[3 * k + c] = this.x[3 * node + c]; });
      this.outline.geometry.attributes.position.needsUpdate = true;
    }
    if (this.cells) this.placeRefined();
    this.lamp.position.copy(this.camera.position).add(new THREE.Vector3(0, 0, this.size || 0));
    this.camera.updateMatrixWorld();
    if (this.renderer) this.renderer.render(this.scene, this.camera);
    this.drawGuide();
    this.isOld = false;
    return true;
  }

  // Axes and a length, in a corner of the picture.
  makeGuide() {
    this.guide = document.createElement('div');
    this.guide.className = 'guide';
    this.guide.style.cssText = 'position: absolute; right: 16px; bottom: var(--guide-bottom, 12px); display: flex; flex-direction: column; align-items: center; gap: 12px;' +
        'font-size: 12px; color: #77797c; pointer-events: none';
    this.guide.innerHTML = '<svg width="64" height="64" viewBox="-32 -32 64 64" role="img" aria-label="axes">' +
        ['x', 'y', 'z'].map(() => '<g><line stroke="currentColor" stroke-width="1.5"/><text text-anchor="middle" dominant-baseline="central" font-size="12" fill="currentColor"></text></g>').join('') +
        '</svg><span class="length" style="display: flex; align-items: end; justify-content: center; height: 6px; padding-bottom: 9px; border: 1px solid; border-top: 0; white-space: nowrap"></span>';
    if (this.renderer) this.container.appendChild(this.guide);
  }

  drawGuide() {
    const m = this.camera.matrixWorldInverse.elements;
    this.guide.querySelectorAll('g').forEach((group, axis) => {
      const x = m[4 * axis], y = -m[4 * axis + 1], [line, name] = group.children;
      line.setAttribute('x2', (20 * x).toFixed(1));
      line.setAttribute('y2', (20 * y).toFixed(1));
      name.setAttribute('x', (27 * x).toFixed(1));
      name.setAttribute('y', (27 * y).toFixed(1));
      name.textContent = 'xyz'[axis];
      group.style.opacity = Math.hypot(x, y) < 0.2 ? 0.25 : 1;
    });
    const away = this.camera.position.distanceTo(this.controls.target), bar = this.guide.querySelector('.length');
    const metres = 2 * away * Math.tan(0.5 * this.camera.fov * Math.PI / 180) / Math.max(1, this.container.clientHeight);  // of a pixel
    const wanted = 90 * metres, power = 10 ** Math.floor(Math.log10(wanted)), length = [5, 2, 1].map(f => f * power).find(v => v <= wanted);
    bar.style.width = `${(length / metres).toFixed(1)}px`;
    bar.textContent = length >= 1 ? `${+length.toPrecision(1)} m` : length >= 1e-3 ? `${+(1e3 * length).toPrecision(1)} mm` : `${+(1e6 * length).toPrecision(1)} µm`;
  }
}
BodyView.MOST_TOUCHED = 400;  // triangles
