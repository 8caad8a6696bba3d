// An orbit around the part, z up: drag turns, shift-drag moves, wheel and pinch zoom, keys do all of it.

const FIELD_OF_VIEW = (30 * Math.PI) / 180, STEEPEST = 1.55;
const START = { azimuth: -1.15, elevation: 0.47, distance: 0.88, aside: 0, above: 0 };
const TURNS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export class Camera {
  constructor(centre, size) {
    Object.assign(this, { centre, size });
    this.reset();
  }

  reset() { Object.assign(this, START); }
  take({ azimuth, elevation, distance, aside, above }) { Object.assign(this, { azimuth, elevation, distance, aside, above }); }
  turn(right, up) {
    this.azimuth -= right;
    this.elevation = clamp(this.elevation + up, -STEEPEST, STEEPEST);
  }
  move(right, up) { this.aside -= right * this.distance; this.above -= up * this.distance; }
  zoom(factor) { this.distance = clamp(this.distance * factor, 0.08, 6); }

  // Unit vectors to the right, up and towards the viewer.
  get axes() {
    const [c, s, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    return [[-s, c, 0], [-se * c, -se * s, ce], [ce * c, ce * s, se]];
  }

  matrices(aspect) {
    const far = (0.5 * this.size) / Math.tan(FIELD_OF_VIEW / 2), reach = far * this.distance * (aspect < 1 ? 1 / aspect : 1) * 1.02;
    const [x, y, z] = this.axes, c = this.centre, shift = [-this.aside * this.size, -this.above * this.size];
    const view = new Float32Array([
      x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, shift[0] - dot(x, c), shift[1] - dot(y, c), -dot(z, c) - reach, 1,
    ]);
    const near = Math.max(reach - 2 * this.size, 0.01 * this.size), end = reach + 2 * this.size, f = 1 / Math.tan(FIELD_OF_VIEW / 2);
    const depth = near - end;
    const projection = new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (end + near) / depth, -1, 0, 0, (2 * end * near) / depth, 0]);
    return { view, projection, upwards: [x[2], y[2], z[2]] };
  }
}

// Lets pointer, wheel and keys steer a camera; returns a function that lets go.
export function steer(canvas, camera, changed) {
  const pointers = new Map(), until = new AbortController(), on = (name, handler) =>
    canvas.addEventListener(name, handler, { signal: until.signal, passive: false });
  const middle = () => [...pointers.values()].reduce((sum, p) => [sum[0] + p[0] / pointers.size, sum[1] + p[1] / pointers.size], [0, 0]);
  const spread = () => { const [a, b] = [...pointers.values()]; return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0; };
  on("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  on("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    const [was, wide] = [middle(), spread()];
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const now = middle(), right = (now[0] - was[0]) / canvas.clientHeight, down = (now[1] - was[1]) / canvas.clientHeight;
    if (pointers.size > 1 || event.shiftKey || event.buttons === 2) camera.move(0.5 * right, -0.5 * down);
    else camera.turn(3 * right, 3 * down);
    if (pointers.size > 1 && wide > 0) camera.zoom(wide / spread());
    changed();
  });
  for (const name of ["pointerup", "pointercancel"]) on(name, (event) => pointers.delete(event.pointerId));
  on("contextmenu", (event) => event.preventDefault());
  on("wheel", (event) => {
    if (document.activeElement !== canvas) return; // until it is clicked, the wheel scrolls the page
    event.preventDefault();
    camera.zoom(Math.exp(clamp(event.deltaY, -100, 100) * 0.002));
    changed();
  });
  on("keydown", (event) => {
    if (event.key in TURNS) camera.turn(0.12 * TURNS[event.key][0], 0.12 * TURNS[event.key][1]);
    else if (event.key === "+" || event.key === "=") camera.zoom(0.87);
    else if (event.key === "-") camera.zoom(1.15);
    else if (event.key === "0") camera.reset();
    else return;
    event.preventDefault();
    event.stopPropagation();
    changed();
  });
  return () => until.abort();
}
