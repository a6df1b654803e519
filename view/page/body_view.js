// The body and the tools in three dimensions. Buffers are made once for a body; an update writes numbers into them.
'use strict';

// Colours that readers with any colour sight can tell apart (sticks and slips: Okabe and Ito). The scale grows darker
// evenly, so that a body at rest is light and what moves stands out.
const SCALE = [[241, 229, 220], [247, 203, 150], [244, 163, 93], [226, 112, 72], [188, 63, 84], [132, 32, 92], [66, 14, 76]].map(c => c.map(v => v / 255));
const STICK = [0 / 255, 114 / 255, 178 / 255], SLIP = [213 / 255, 94 / 255, 0 / 255], PLAIN = [0.80, 0.62, 0.56];

function colourOf(share, out) {
  const at = Math.min(1, Math.max(0, share)) * (SCALE.length - 1), i = Math.min(SCALE.length - 2, Math.floor(at)), s = at - i;
  for (let c = 0; c < 3; ++c) out[c] = (1 - s) * SCALE[i][c] + s * SCALE[i + 1][c];
}

class BodyView {
  // container: an element with a size. Needs THREE and THREE.OrbitControls.
  constructor(container) {
    this.container = container;
    // Where a picture is drawn by the processor, smooth edges cost most of its time, and the body needs that processor too.
    this.isSoftware = BodyView.isDrawnBySoftware();
    this.renderer = new THREE.WebGLRenderer({antialias: !this.isSoftware, alpha: true, preserveDrawingBuffer: true});
    this.sharpness = this.isSoftware ? 0.75 : 1;  // pixels of the picture to one of the screen
    this.setSharpness(this.sharpness);
    container.appendChild(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.001, 10);
    this.camera.up.set(0, 0, 1);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x9098a8, 0.62));
    this.lamp = new THREE.DirectionalLight(0xffffff, 0.42);
    this.scene.add(this.lamp);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableKeys = false;
    this.controls.addEventListener('change', () => { this.isOld = true; });
    this.colour = 'displacement';
    this.marks = new THREE.Group();
    this.scene.add(this.marks);
    this.tools = [];
    this.scale = 0;      // of the colours [m]
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

  setSharpness(sharpness) {
    this.sharpness = sharpness;
    this.renderer.setPixelRatio(sharpness * Math.min(2, window.devicePixelRatio || 1));
    this.isOld = true;
  }

  resize() {
    const w = Math.max(1, this.container.clientWidth), h = Math.max(1, this.container.clientHeight);
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.isOld = true;
  }

  // body: {x: Float32Array at rest [m], triangles: Uint32Array}. smooth: the contact surface is.
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
    const look = {vertexColors: THREE.VertexColors, side: BodyView.isClosed(body.triangles) ? THREE.FrontSide : THREE.DoubleSide};
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
    this.scale = 0;
    this.mostForce = 0.1;
    this.makeMarks();
    this.fit();
  }

  makeMarks() {
    while (this.marks.children.length) this.marks.remove(this.marks.children[0]);
    const line = (n, colour, dashed) => {
      const g = new THREE.BufferGeometry();
      g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * n), 3));
      const l = new THREE.LineSegments(g, new THREE.LineBasicMaterial({color: colour, depthTest: !dashed, transparent: true}));
      l.frustumCulled = false;
      this.marks.add(l);
      return l;
    };
    this.outline = null;
    this.spring = line(2 * 24, 0x777777, true);
    const ball = (r, colour) => {
      const m = new THREE.Mesh(new THREE.SphereGeometry(r, 16, 12), new THREE.MeshBasicMaterial({color: colour, depthTest: false, transparent: true, opacity: 0.8}));
      this.marks.add(m);
      return m;
    };
    this.cursor = ball(0.006 * this.size, 0x555555);
    const arrow = colour => {
      const a = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, colour);
      a.line.material.depthTest = a.cone.material.depthTest = false;
      a.line.material.linewidth = 2;
      a.visible = false;
      this.marks.add(a);
      return a;
    };
    this.normals = [arrow(0x888888), arrow(0x888888)];
    this.forces = [arrow(0xcc3311), arrow(0xcc3311)];
  }

  // tools: [{shape, radius, corners, triangles}], lengths in m.
  setTools(tools) {
    for (const t of this.tools) this.scene.remove(t.object);
    this.tools = tools.map(tool => {
      const material = new THREE.MeshPhongMaterial({color: 0x3a4654, shininess: 60, transparent: true, opacity: 0.82});
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
    this.outline = new THREE.LineSegments(g, new THREE.LineBasicMaterial({color: 0x222222, transparent: true, opacity: 0.55}));
    this.outline.frustumCulled = false;
    this.marks.add(this.outline);
    this.patch = new Set(refresh.triangles);
    this.patchNodes = new Set();
    for (const t of refresh.triangles) for (let c = 0; c < 3; ++c) this.patchNodes.add(this.triangles[3 * t + c]);
    this.distance.fill(0);
    refresh.nodes.forEach((node, k) => { this.distance[node] = refresh.distance[k]; });
    this.isOld = true;
  }

  // frame: as readMessage() gives it. options.hand: the tool is held to frame.target by a spring.
  update(frame, options = {}) {
    unpackPositions(frame, this.x);
    this.position.needsUpdate = true;
    if (this.smooth) this.mesh.geometry.computeVertexNormals();
    this.frame = frame;
    frame.tools.forEach((tool, k) => {
      const shown = this.tools[k];
      if (!shown) return;
      shown.object.position.set(tool.x[0], tool.x[1], tool.x[2]);
      shown.object.quaternion.set(tool.r[0], tool.r[1], tool.r[2], tool.r[3]);
      this.mostForce = Math.max(this.mostForce, Math.hypot(...tool.force));
      this.point(this.forces[k], tool.x, tool.force, Math.hypot(...tool.force) * this.metresPerNewton());
      this.point(this.normals[k], tool.point, tool.normal, tool.mode > 0 ? 0.12 * this.size : 0);
    });
    this.showSpring(frame, options.hand);
    this.colourIn();
    this.isOld = true;
  }

  // Length of a force arrow: the largest force so far is about a third of the body's size, in round numbers.
  metresPerNewton() {
    const wanted = 1000 * 0.3 * this.size / Math.max(this.mostForce, 1e-6), power = 10 ** Math.floor(Math.log10(wanted));
    return [5, 2, 1].map(f => f * power).find(v => v <= wanted) / 1000;
  }

  point(arrow, from, along, length) {
    arrow.visible = length > 0.004 * this.size;
    if (!arrow.visible) return;
    arrow.position.set(from[0], from[1], from[2]);
    arrow.setDirection(new THREE.Vector3(along[0], along[1], along[2]).normalize());
    const shown = Math.min(length, 1.5 * this.size);
    arrow.setLength(shown, Math.min(0.3 * shown, 0.05 * this.size), Math.min(0.15 * shown, 0.025 * this.size));
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
    const paint = this.paint.array, x = this.x, rest = this.rest, c = [0, 0, 0], n = x.length / 3;
    if (this.colour === 'displacement' || this.colour === 'error') {
      const values = this.values || (this.values = new Float32Array(n));
      const v = values.length === n ? values : (this.values = new Float32Array(n));
      let most = 0;
      for (let i = 0; i < n; ++i) {
        v[i] = this.colour === 'error' ? this.distance[i] : Math.hypot(x[3 * i] - rest[3 * i], x[3 * i + 1] - rest[3 * i + 1], x[3 * i + 2] - rest[3 * i + 2]);
        if (v[i] > most) most = v[i];
      }
      // A scale that grows at once and shrinks slowly: colours do not flicker.
      const least = (this.colour === 'error' ? 1e-5 : 1e-3) * this.size;
      this.scale = Math.max(most, least, 0.995 * this.scale);
      for (let i = 0; i < n; ++i) {
        colourOf(v[i] / this.scale, c);
        paint[3 * i] = c[0]; paint[3 * i + 1] = c[1]; paint[3 * i + 2] = c[2];
      }
    } else {
      const mode = this.frame ? this.frame.tools[0].mode : 0, shown = this.colour === 'mode' && mode > 0;
      const touched = mode === 1 ? STICK : SLIP;
      for (let i = 0; i < n; ++i) {
        const own = shown && this.patchNodes && this.patchNodes.has(i) ? touched : PLAIN;
        paint[3 * i] = own[0]; paint[3 * i + 1] = own[1]; paint[3 * i + 2] = own[2];
      }
    }
    this.paint.needsUpdate = true;
  }

  setColour(colour) {
    this.colour = colour;
    this.scale = 0;
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
    this.lamp.position.copy(this.camera.position).add(new THREE.Vector3(0, 0, this.size || 0));
    this.renderer.render(this.scene, this.camera);
    this.isOld = false;
    return true;
  }
}
