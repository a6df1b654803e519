// From mouse, pen, finger and keys to the place where the hand is to go.
'use strict';

class ToolPointer {
  // view: a BodyView; send(x): a new place [m]; depth(): chosen depth of a press [m]; changeDepth(by)
  constructor(view, send, depth, changeDepth) {
    Object.assign(this, {view, send, depth, changeDepth});
    this.mode = null;     // 'tool', 'press' while a button is down
    this.route = [];      // places on the way to a press
    this.target = null;   // THREE.Vector3
    this.mayMove = true;
    this.ray = new THREE.Raycaster();
    const e = view.surface;
    e.addEventListener('pointerdown', event => this.down(event));
    e.addEventListener('pointermove', event => this.move(event));
    for (const name of ['pointerup', 'pointercancel']) e.addEventListener(name, event => this.up(event));
    e.addEventListener('wheel', event => this.wheel(event), {capture: true, passive: false});
    e.addEventListener('contextmenu', event => event.preventDefault());
  }

  setRay(event) {
    const box = this.view.surface.getBoundingClientRect();
    const at = new THREE.Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    this.ray.setFromCamera(at, this.view.camera);
    return {x: event.clientX - box.left, y: event.clientY - box.top, box};
  }

  tool() {
    const f = this.view.frame;
    return f ? f.tools[0] : null;
  }

  // Whether the tool is under the pointer, or so small that it is near enough.
  isOnTool(place) {
    const tool = this.tool();
    if (!tool || !this.view.tools[0]) return false;
    if (this.ray.intersectObject(this.view.tools[0].object, true).length) return true;
    const on = new THREE.Vector3(...tool.x).project(this.view.camera);
    const dx = (on.x + 1) / 2 * place.box.width - place.x, dy = (1 - on.y) / 2 * place.box.height - place.y;
    return Math.hypot(dx, dy) < 14;
  }

  // The body at rest under the pointer: place and outward normal, even over a triangle's edges.
  hit() {
    const found = this.ray.intersectObject(this.view.still)[0];
    if (!found) return null;
    const normals = this.view.still.geometry.attributes.normal, x = this.view.rest, {a, b, c} = found.face;
    const corner = i => new THREE.Vector3(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    const bary = new THREE.Vector3();
    new THREE.Triangle(corner(a), corner(b), corner(c)).getBarycoord(found.point, bary);
    const normal = new THREE.Vector3();
    [a, b, c].forEach((i, k) => normal.addScaledVector(new THREE.Vector3(normals.getX(i), normals.getY(i), normals.getZ(i)), bary.getComponent(k)));
    return {point: found.point.clone(), normal: normal.normalize()};
  }

  pressed(hit, depth) {
    const tool = this.view.tools[0], r = this.tool().r;
    return hit.point.clone().addScaledVector(hit.normal, this.view.support(tool, r, hit.normal) - depth);
  }

  down(event) {
    this.view.container.focus({preventScroll: true});
    if (!this.mayMove || !this.tool() || event.button !== 0 || this.mode) return;
    const place = this.setRay(event);
    if (this.isOnTool(place)) {
      this.mode = 'tool';
      const x = new THREE.Vector3(...this.tool().x);
      this.plane = new THREE.Plane().setFromNormalAndCoplanarPoint(this.view.camera.getWorldDirection(new THREE.Vector3()), x);
      this.offset = x.clone().sub(this.ray.ray.intersectPlane(this.plane, new THREE.Vector3()) || x);
      this.route = [];
    } else {
      const hit = this.hit();
      if (!hit) return;  // beside the body: the camera's
      this.mode = 'press';
      this.lastHit = hit;
      this.goTo(hit);
    }
    this.start = {x: event.clientX, y: event.clientY};
    this.wasMoved = false;
    this.view.controls.enabled = false;
    event.target.setPointerCapture(event.pointerId);
    event.preventDefault();
  }

  move(event) {
    if (!this.mode) return;
    if (Math.hypot(event.clientX - this.start.x, event.clientY - this.start.y) > 4) this.wasMoved = true;
    this.setRay(event);
    if (this.mode === 'tool') {
      const on = this.ray.ray.intersectPlane(this.plane, new THREE.Vector3());
      if (on) this.aim(on.add(this.offset));
    } else {
      const hit = this.hit();
      if (!hit || !this.wasMoved) return;
      this.lastHit = hit;
      if (this.route.length > 1) this.route[this.route.length - 1] = this.pressed(hit, this.depth());
      else { this.route = []; this.aim(this.pressed(hit, this.depth())); }
    }
  }

  up(event) {
    if (!this.mode) return;
    // A click alone holds the tool there; at the end of a drag it leaves the body.
    if (this.mode === 'press' && this.wasMoved) this.lift();
    this.mode = null;
    this.view.controls.enabled = true;
  }

  wheel(event) {
    if (!this.mode) return;
    event.preventDefault();
    event.stopPropagation();
    const by = (event.deltaY > 0 ? 1 : -1) * 0.0005;
    if (this.mode === 'tool') {
      const way = this.view.camera.getWorldDirection(new THREE.Vector3());
      this.plane.translate(way.clone().multiplyScalar(by));
      this.aim(this.target.clone().addScaledVector(way, by));
    } else {
      this.changeDepth(by);
      this.aim(this.pressed(this.lastHit, this.depth()));
    }
  }

  // 1 mm along the screen's right and up, and away from the viewer.
  step(right, up, away) {
    const at = this.target || (this.tool() && new THREE.Vector3(...this.tool().x));
    if (!at || !this.mayMove) return;
    const m = this.view.camera.matrixWorld.elements;
    const way = new THREE.Vector3(m[0], m[1], m[2]).multiplyScalar(right).addScaledVector(new THREE.Vector3(m[4], m[5], m[6]), up)
        .addScaledVector(new THREE.Vector3(-m[8], -m[9], -m[10]), away);
    this.route = [];
    this.aim(at.clone().addScaledVector(way, 0.001));
  }

  // Out of the body along the last normal.
  lift() {
    const tool = this.tool();
    if (!tool || !this.mayMove) return;
    this.route = [];
    const normal = new THREE.Vector3(...tool.normal);
    if (normal.lengthSq() < 0.5) return;
    this.aim(new THREE.Vector3(...tool.x).addScaledVector(normal, 0.15 * this.view.size));
  }

  // To a press there: straight when the way is free, else around the body.
  goTo(hit) {
    const view = this.view, here = new THREE.Vector3(...this.tool().x), press = this.pressed(hit, this.depth());
    const clear = view.support(view.tools[0], this.tool().r, hit.normal) + 0.04 * view.size;
    const above = hit.point.clone().addScaledVector(hit.normal, clear);
    const {center, radius} = view.still.geometry.boundingSphere;
    const isFree = (a, b) => {
      const way = b.clone().sub(a), length = way.length();
      if (length < 1e-9) return true;
      return new THREE.Raycaster(a, way.divideScalar(length), 0, length).intersectObject(view.still).length === 0;
    };
    const near = here.distanceTo(press) < 3 * view.tools[0].radius + 0.02 * view.size;
    this.route = [];
    if (!near) {
      let from = here;
      const normal = new THREE.Vector3(...this.tool().normal);
      if (this.tool().mode > 0 && normal.lengthSq() > 0.5) {
        from = here.clone().addScaledVector(normal, clear);
        this.route.push(from);
      }
      if (!isFree(from, above)) {
        const far = 1.15 * radius + clear, a = from.clone().sub(center).normalize(), b = above.clone().sub(center).normalize();
        const turn = new THREE.Quaternion().setFromUnitVectors(a, b), steps = Math.max(1, Math.ceil(a.angleTo(b) / 0.4));
        for (let i = 0; i <= steps; ++i)
          this.route.push(a.clone().applyQuaternion(new THREE.Quaternion().slerp(turn, i / steps)).multiplyScalar(far).add(center));
      }
      this.route.push(above);
    }
    this.route.push(press);
    this.aim(this.route[0]);
  }

  aim(x) {
    this.target = x.clone();
    this.send(x);
  }

  // Each frame: on to the next place when the tool is near this one.
  follow() {
    if (this.route.length < 2 || !this.tool()) return;
    const here = new THREE.Vector3(...this.tool().x);
    if (here.distanceTo(this.route[0]) > 0.02 * this.view.size && this.tool().mode === 0) return;
    if (here.distanceTo(this.route[0]) > 0.06 * this.view.size) return;
    this.route.shift();
    this.aim(this.route[0]);
  }

  reset() {
    this.mode = null;
    this.route = [];
    this.target = null;
    this.view.controls.enabled = true;
  }
}
