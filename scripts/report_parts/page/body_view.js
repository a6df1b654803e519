// A body's surface with the tools that touch it, drawn by three.js (r111).
'use strict';
class BodyView {
  // container: an element with a size. triangles: Uint32Array. rest: Float32Array, 3 a node [m]. flat: the surface is its triangles; else smooth.
  // tools: [{shape, radius, corners, triangles}]. up, direction: towards the sky and towards the eye. largestForce [N]: of the longest arrow.
  constructor(container, {triangles, rest, flat, tools, up, direction, largestForce}) {
    this.container = container;
    this.rest = rest;
    this.renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    container.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(rest), 3));
    this.geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(rest.length), 3));
    this.geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    this.geometry.computeBoundingSphere();
    this.size = this.geometry.boundingSphere.radius;
    this.centre = this.geometry.boundingSphere.center.clone();
    this.flat = flat;
    const body = new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, flatShading: flat, side: THREE.DoubleSide, shininess: 12, specular: 0x222222});
    const mesh = new THREE.Mesh(this.geometry, body);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    if (flat) {
      const lines = new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial({wireframe: true, color: 0x000000, transparent: true, opacity: 0.1}));
      lines.frustumCulled = false;
      this.scene.add(lines);
    }
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8a8a, 0.75));
    this.light = new THREE.DirectionalLight(0xffffff, 0.55);
    this.scene.add(this.light);
    this.camera = new THREE.PerspectiveCamera(35, 1, this.size * 0.01, this.size * 100);
    this.up = new THREE.Vector3(...up).normalize();
    this.offset = new THREE.Vector3(...direction).normalize().multiplyScalar(this.size * 3.6);
    this.largestForce = largestForce;
    this.tools = tools.map(tool => this.makeTool(tool));
    this.colourBy('displacement', 0);
    this.turnByHand();
    new ResizeObserver(() => this.resize()).observe(container);
    this.resize();
  }

  makeTool({shape, radius, corners, triangles}) {
    const group = new THREE.Group(), material = new THREE.MeshPhongMaterial({color: 0xf4f4f4, specular: 0x333333});
    const ball = (at, r) => { const one = new THREE.Mesh(new THREE.SphereBufferGeometry(r, 32, 20), material); one.position.set(...at); group.add(one); };
    if (shape === 'mesh') {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(corners.flat()), 3));
      geometry.setIndex(triangles.flat());
      material.flatShading = true;
      group.add(new THREE.Mesh(geometry, material));
    } else if (shape === 'capsule') {
      const [a, b] = corners.map(c => new THREE.Vector3(...c)), along = b.clone().sub(a);
      const rod = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius, radius, along.length(), 32, 1, true), material);
      rod.position.copy(a).add(b).multiplyScalar(0.5);
      rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
      group.add(rod);
      corners.forEach(c => ball(c, radius));
    } else if (radius > 0) {
      ball([0, 0, 0], radius);
    } else {
      material.color.set(0xd55e00);
      ball([0, 0, 0], this.size * 0.012);
    }
    const arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, 0xd55e00);
    const normal = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({color: 0x888888}));
    normal.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(6), 3));
    normal.frustumCulled = false;
    this.scene.add(group, arrow, normal);
    return {group, arrow, normal};
  }

  // x: Float32Array of the nodes [m]. states: for each tool {place, turn: [w, x, y, z], force, normal}.
  update(x, states) {
    const position = this.geometry.attributes.position;
    position.array.set(x);
    position.needsUpdate = true;
    if (!this.flat) this.geometry.computeVertexNormals();
    this.paint(x);
    states.forEach(({place, turn, force, normal}, k) => {
      const tool = this.tools[k], at = new THREE.Vector3(...place), f = new THREE.Vector3(...force), n = new THREE.Vector3(...normal);
      tool.group.position.copy(at);
      tool.group.quaternion.set(turn[1], turn[2], turn[3], turn[0]);
      const length = 0.7 * this.size * f.length() / this.largestForce;
      tool.arrow.visible = length > 0.02 * this.size;
      if (tool.arrow.visible) {
        tool.arrow.position.copy(at);
        tool.arrow.setDirection(f.normalize());
        tool.arrow.setLength(length, 0.14 * this.size, 0.07 * this.size);
      }
      tool.normal.visible = n.lengthSq() > 0;
      const ends = tool.normal.geometry.attributes.position;
      ends.array.set([...at.toArray(), ...at.clone().addScaledVector(n, 0.45 * this.size).toArray()]);
      ends.needsUpdate = true;
    });
    this.render();
  }

  // what: displacement (from light to dark, up to `most` [m]) or plain.
  colourBy(what, most) {
    this.what = what;
    this.most = most || this.most || 0;
  }
  paint(x) {
    const colours = this.geometry.attributes.color, out = colours.array, stops = [[0.97, 0.97, 0.82], [0.5, 0.8, 0.73], [0.17, 0.5, 0.72], [0.13, 0.18, 0.55]];
    for (let i = 0; i < x.length; i += 3) {
      const moved = this.what === 'plain' ? 0 : Math.hypot(x[i] - this.rest[i], x[i + 1] - this.rest[i + 1], x[i + 2] - this.rest[i + 2]);
      const at = Math.min(2.999, 3 * moved / (this.most || 1)), k = Math.floor(at), rest = at - k;
      for (let c = 0; c < 3; ++c) out[i + c] = this.what === 'plain' ? [0.78, 0.62, 0.56][c] : stops[k][c] + rest * (stops[k + 1][c] - stops[k][c]);
    }
    colours.needsUpdate = true;
  }

  turnByHand() {
    const canvas = this.renderer.domElement, down = new Map();
    const turn = (dx, dy) => {
      const right = new THREE.Vector3().crossVectors(this.up, this.offset).normalize();
      this.offset.applyAxisAngle(this.up, -0.008 * dx);
      const angle = this.offset.angleTo(this.up), next = Math.min(Math.PI - 0.05, Math.max(0.05, angle - 0.008 * dy));
      this.offset.applyAxisAngle(right.applyAxisAngle(this.up, -0.008 * dx), next - angle);
    };
    const nearer = factor => this.offset.setLength(Math.min(this.size * 20, Math.max(this.size * 0.6, this.offset.length() * factor)));
    const spread = () => { const [a, b] = [...down.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    canvas.addEventListener('pointerdown', e => { canvas.setPointerCapture(e.pointerId); down.set(e.pointerId, {x: e.clientX, y: e.clientY}); });
    canvas.addEventListener('pointermove', e => {
      const last = down.get(e.pointerId);
      if (!last) return;
      const before = down.size === 2 ? spread() : 0;
      down.set(e.pointerId, {x: e.clientX, y: e.clientY});
      if (down.size === 2) nearer(before / Math.max(1, spread()));
      else turn(e.clientX - last.x, e.clientY - last.y);
      this.render();
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, e => down.delete(e.pointerId));
    canvas.addEventListener('wheel', e => { e.preventDefault(); nearer(Math.exp(0.001 * e.deltaY)); this.render(); }, {passive: false});
  }

  resize() {
    const {clientWidth: w, clientHeight: h} = this.container;
    if (!w || !h) return;
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.render();
  }
  render() {
    this.camera.up.copy(this.up);
    this.camera.position.copy(this.centre).add(this.offset);
    this.camera.lookAt(this.centre);
    this.light.position.copy(this.offset).addScaledVector(this.up, this.size * 3);
    this.renderer.render(this.scene, this.camera);
  }
}
