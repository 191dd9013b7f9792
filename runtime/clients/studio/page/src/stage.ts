// A scene in three dimensions that is drawn when something changes. z is up, lengths are mm.
import {
  AmbientLight, Box3, Box3Helper, DirectionalLight, Group, Line, LineBasicMaterial, LineLoop, BufferGeometry, Mesh, MeshBasicMaterial, type Object3D, PerspectiveCamera, Plane,
  Raycaster, Scene, SphereGeometry, Spherical, Vector2, Vector3, WebGLRenderer, type Material,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

export interface Content {
  object: Object3D;
  box: Vector3; // its edges; one corner is at the origin
  cut(planes: Plane[]): void;
  coarse?(on: boolean): void; // a form that is drawn faster, while the view moves
  dispose(): void;
}

// One camera for all scenes, so that what is compared is seen from the same place.
const view = { position: new Vector3(), target: new Vector3(), size: 0 };
export const sun = new Vector3(-0.6, -1, 1.4).normalize(); // where the light comes from, in all stages

export function hasWebGL(): boolean {
  try {
    return !!document.createElement('canvas').getContext('webgl2');
  } catch {
    return false;
  }
}

export class Stage {
  readonly canvas: HTMLCanvasElement;
  onPlane: ((plane: Plane) => void) | null = null; // while the plane is dragged
  private renderer: WebGLRenderer;
  private scenes = [new Scene(), new Scene()]; // what is shown; what it is compared with
  private contents: (Content | null)[] = [null, null];
  private camera = new PerspectiveCamera(30, 1, 0.01, 1000);
  private controls: OrbitControls;
  private plane: Plane | null = null;
  private facing = 0; // 1 if the camera is on the plane's positive side, else −1; 0: not known
  private lights: DirectionalLight[] = [];
  private marks = new Group();
  private share = 0.5;
  private asked = false;
  private observer: ResizeObserver;
  private moving = false;
  private coarse = false; // while the view moves, if drawing is slow
  private slow = false; // what is shown took long to draw
  private painted = 0; // when

  constructor(private host: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, powerPreference: 'high-performance' });
    this.renderer.localClippingEnabled = true;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.canvas = this.renderer.domElement;
    host.prepend(this.canvas);
    for (const scene of this.scenes) {
      const light = new DirectionalLight(0xffffff, 2.2);
      scene.add(new AmbientLight(0xffffff, 1.1), light);
      this.lights.push(light);
    }
    this.scenes[0].add(this.marks);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => {
      view.position.copy(this.camera.position), view.target.copy(this.controls.target);
      if (this.plane && this.side(this.plane) !== this.facing) this.cut(this.plane);
      this.draw();
    });
    this.controls.addEventListener('start', () => {
      this.moving = true, this.painted = 0;
      if (this.slow) this.setCoarse(true);
    });
    this.controls.addEventListener('end', () => {
      this.moving = false;
      if (this.coarse) this.setCoarse(false), this.draw();
    });
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.canvas.addEventListener('pointerdown', this.grab, { capture: true });
    this.canvas.addEventListener('webglcontextlost', e => e.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => this.draw());
  }

  show(content: Content | null, at: 0 | 1 = 0) {
    const old = this.contents[at];
    if (old) this.scenes[at].remove(old.object);
    this.contents[at] = content;
    this.slow = false;
    if (this.coarse) this.setCoarse(false);
    if (content) this.scenes[at].add(content.object);
    const main = this.contents[0] ?? this.contents[1];
    if (main && at === 0) {
      const size = main.box.length();
      if (!view.size) this.lookAt(main.box, new Vector3(-0.55, -1, 0.62));
      else if (Math.abs(view.size / size - 1) > 0.02) { // another size: the same view of it
        const scale = size / view.size, target = main.box.clone().multiplyScalar(0.5);
        this.place(target.clone().addScaledVector(view.position.clone().sub(view.target), scale), target, size);
      } else this.place(view.position, view.target, size);
    }
    this.cut(this.plane);
    this.draw();
  }

  lookAt(box: Vector3, from: Vector3) {
    const size = box.length(), target = box.clone().multiplyScalar(0.5);
    this.place(target.clone().addScaledVector(from.normalize(), 1.9 * size), target, size);
    this.draw();
  }

  private place(position: Vector3, target: Vector3, size: number) {
    this.camera.near = size / 200, this.camera.far = size * 20;
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(position), this.controls.target.copy(target);
    view.position.copy(position), view.target.copy(target), view.size = size;
    this.controls.update();
  }

  // Where the pictures of both contents meet: 0 is left.
  wipe(share: number) {
    this.share = share;
    this.draw();
  }

  // Hides what is between the plane and the camera, so that the cut is seen.
  cut(plane: Plane | null) {
    this.plane = plane;
    this.facing = plane ? this.side(plane) : 0;
    const clip = plane && (this.facing > 0 ? plane.clone().negate() : plane);
    for (const c of this.contents) c?.cut(clip ? [clip] : []);
    const content = this.contents[0];
    this.marks.clear();
    if (content) {
      const frame = new Box3Helper(new Box3(new Vector3(), content.box.clone()));
      const lines = frame.material as LineBasicMaterial;
      lines.color.set(0x808489), lines.transparent = true, lines.opacity = 0.6;
      this.marks.add(frame);
    }
    if (content && plane) {
      const outline = intersection(plane, content.box);
      const color = new LineBasicMaterial({ color: 0x4a8ee6, depthTest: false });
      if (outline.length) this.marks.add(new LineLoop(new BufferGeometry().setFromPoints(outline), color));
      const [a, b] = this.handle()!;
      const knob = new Mesh(new SphereGeometry(0.014 * content.box.length(), 16, 12), new MeshBasicMaterial({ color: 0x4a8ee6, depthTest: false, transparent: true }));
      knob.position.copy(b);
      knob.visible = !!this.onPlane;
      this.marks.add(new Line(new BufferGeometry().setFromPoints([a, b]), color), knob);
      this.marks.children.forEach(c => { c.renderOrder = 10; });
    }
    this.draw();
  }

  private side(plane: Plane) {
    return plane.distanceToPoint(this.camera.position) > 0 ? 1 : -1;
  }

  // From the middle of the plane towards the camera's side, to where it is grabbed.
  private handle(): [Vector3, Vector3] | null {
    const content = this.contents[0];
    if (!this.plane || !content) return null;
    const outline = intersection(this.plane, content.box), middle = new Vector3();
    if (outline.length) outline.forEach(p => middle.addScaledVector(p, 1 / outline.length));
    else this.plane.projectPoint(content.box.clone().multiplyScalar(0.5), middle);
    return [middle, middle.clone().addScaledVector(this.plane.normal, 0.16 * this.facing * content.box.length())];
  }

  private screen(p: Vector3): Vector2 {
    const q = p.clone().project(this.camera), r = this.canvas.getBoundingClientRect();
    return new Vector2(r.left + ((q.x + 1) / 2) * r.width, r.top + ((1 - q.y) / 2) * r.height);
  }

  // Moves the light around the solid, in degrees.
  turnLight(right: number, up: number) {
    const at = new Spherical().setFromVector3(new Vector3(sun.x, sun.z, -sun.y));
    at.theta += (right * Math.PI) / 180, at.phi = Math.min(Math.max(at.phi - (up * Math.PI) / 180, 0.05), 1.5);
    const v = new Vector3().setFromSpherical(at);
    sun.set(v.x, -v.z, v.y);
    this.draw();
  }

  // With Shift, dragging turns the light, if there is no plane to be moved.
  private lit(e: PointerEvent) {
    e.stopImmediatePropagation(), e.preventDefault();
    let [x, y] = [e.clientX, e.clientY];
    const move = (m: PointerEvent) => { this.turnLight(0.5 * (m.clientX - x), 0.5 * (y - m.clientY)), [x, y] = [m.clientX, m.clientY]; };
    const up = () => { window.removeEventListener('pointermove', move), window.removeEventListener('pointerup', up); };
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', up);
  }

  // The plane is grabbed at its handle, or with Shift anywhere.
  private grab = (e: PointerEvent) => {
    const handle = this.handle();
    if (e.shiftKey && !e.button && !this.onPlane) return this.lit(e);
    if (!handle || !this.onPlane || e.button) return;
    const [a, b] = handle.map(p => this.screen(p)), along = b.clone().sub(a);
    const at = new Vector2(e.clientX, e.clientY), length = Math.max(along.length(), 8);
    const t = Math.min(Math.max(at.clone().sub(a).dot(along) / length ** 2, 0), 1);
    if (!e.shiftKey && at.distanceTo(a.clone().addScaledVector(along, t)) > 12) return;
    e.stopImmediatePropagation(), e.preventDefault();
    const start = this.plane!.clone(), world = handle[1].distanceTo(handle[0]) / length, direction = along.normalize();
    const move = (m: PointerEvent) => {
      const by = -this.facing * new Vector2(m.clientX, m.clientY).sub(at).dot(direction) * world;
      this.onPlane?.(new Plane(start.normal.clone(), start.constant + by));
    };
    const up = () => {
      window.removeEventListener('pointermove', move);
      window.removeEventListener('pointerup', up);
    };
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', up);
  };

  // What is under the pointer: the object, and which instance of it.
  pick(x: number, y: number): { object: Object3D; instance: number } | null {
    const content = this.contents[0];
    if (!content) return null;
    const r = this.canvas.getBoundingClientRect(), ray = new Raycaster();
    ray.setFromCamera(new Vector2(((x - r.left) / r.width) * 2 - 1, 1 - ((y - r.top) / r.height) * 2), this.camera);
    const hit = ray.intersectObject(content.object, true).find(h => !this.plane || this.facing * this.plane.distanceToPoint(h.point) <= 0);
    return hit ? { object: hit.object, instance: hit.instanceId ?? 0 } : null;
  }

  turn(right: number, up: number) { // degrees; for keys
    const offset = this.camera.position.clone().sub(this.controls.target);
    const phi = Math.min(Math.max(Math.acos(offset.z / offset.length()) - (up * Math.PI) / 180, 0.05), 3.09);
    const theta = Math.atan2(offset.y, offset.x) + (right * Math.PI) / 180, r = offset.length();
    offset.set(r * Math.sin(phi) * Math.cos(theta), r * Math.sin(phi) * Math.sin(theta), r * Math.cos(phi));
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }
  zoom(factor: number) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }

  draw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.paint();
    });
  }

  // The canvas with what is shown, to be read at once: the browser clears it later.
  picture(): HTMLCanvasElement {
    if (this.coarse) this.setCoarse(false);
    this.paint();
    return this.canvas;
  }

  private setCoarse(on: boolean) {
    this.coarse = on;
    for (const c of this.contents) c?.coarse?.(on);
    this.renderer.setPixelRatio(on ? 0.5 : Math.min(window.devicePixelRatio, 2));
  }

  private paint() {
    const now = performance.now();
    if (this.moving && !this.coarse && this.painted && now - this.painted > 50) this.slow = true, this.setCoarse(true);
    this.painted = now;
    const r = this.renderer, { clientWidth: w, clientHeight: h } = this.host;
    if (!w || !h) return;
    this.camera.updateMatrixWorld();
    r.setScissorTest(false);
    r.autoClear = false;
    r.clear();
    for (const light of this.lights) light.position.copy(sun);
    if (!this.contents[1]) return r.render(this.scenes[0], this.camera);
    const x = Math.round(w * this.share);
    r.setScissorTest(true);
    r.setScissor(0, 0, x, h);
    r.render(this.scenes[1], this.camera);
    r.setScissor(x, 0, w - x, h);
    r.render(this.scenes[0], this.camera);
  }

  private resize() {
    const { clientWidth: w, clientHeight: h } = this.host;
    if (!w || !h) return;
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.paint(); // at once, since the canvas was cleared
  }

  dispose() {
    this.observer.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.canvas.remove();
  }
}

// Where a plane meets a box: the corners of a convex polygon, in order.
export function intersection(plane: Plane, box: Vector3): Vector3[] {
  const out: Vector3[] = [];
  for (let axis = 0; axis < 3; ++axis)
    for (let k = 0; k < 4; ++k) {
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      const p = new Vector3().setComponent(u, k & 1 ? box.getComponent(u) : 0).setComponent(v, k & 2 ? box.getComponent(v) : 0);
      const n = plane.normal.getComponent(axis), edge = box.getComponent(axis);
      if (Math.abs(n) < 1e-9) continue;
      const t = -plane.distanceToPoint(p) / n;
      if (t >= -1e-6 * edge && t <= edge * (1 + 1e-6)) out.push(p.setComponent(axis, t));
    }
  const distinct = out.filter((p, k) => out.findIndex(q => q.distanceTo(p) < 1e-6 * box.length()) === k);
  if (distinct.length < 3) return [];
  const middle = distinct.reduce((s, p) => s.addScaledVector(p, 1 / distinct.length), new Vector3());
  const x = distinct[0].clone().sub(middle).normalize(), y = plane.normal.clone().cross(x);
  const angle = (p: Vector3) => Math.atan2(p.clone().sub(middle).dot(y), p.clone().sub(middle).dot(x));
  return distinct.sort((a, b) => angle(a) - angle(b));
}

export function disposeMesh(mesh: Mesh) {
  mesh.geometry.dispose();
  for (const m of Array.isArray(mesh.material) ? mesh.material : [mesh.material]) (m as Material).dispose();
}
