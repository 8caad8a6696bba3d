// The replay: a part to turn, layers to choose, a slider over all iterations, a colour bar with its threshold.

import { Camera, steer } from "./camera.js";
import { plane } from "./replay_data.js";
import { Scene } from "./scene.js";

const KEYS_HELP = "Drag to turn, shift-drag to move, click and scroll to zoom. Keys: arrows turn or scrub, + and − zoom, 0 resets, " +
  "space plays, n and p go to the next and previous simulation, 1 to 6 choose the layer, o shows the original beside it.";

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made && typeof value !== "string") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

const shown = (value) => Number(value.toPrecision(3)).toString();
const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;
const withUnit = (value, unit) => (unit ? `${shown(value)} ${unit}` : shown(value));

// A third of the area of the faces around each vertex, for shares of the surface.
function vertexAreas({ positions: p, faces, vertices }) {
  const areas = new Float32Array(vertices);
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [3 * faces[i], 3 * faces[i + 1], 3 * faces[i + 2]];
    const u = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]], v = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
    const area = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 6;
    for (let corner = 0; corner < 3; corner++) areas[faces[i + corner]] += area;
  }
  return areas;
}

function boxOf(p) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < p.length; i++) { low[i % 3] = Math.min(low[i % 3], p[i]); high[i % 3] = Math.max(high[i % 3], p[i]); }
  return { centre: low.map((v, k) => 0.5 * (v + high[k])), size: Math.hypot(...low.map((v, k) => high[k] - v)) };
}

export class Player {
  // `changed` is told { iteration, layer, threshold } when a person changed one of them.
  constructor(root, replay, changed = () => {}) {
    Object.assign(this, { root, replay, changed, frame: replay.frames.length - 1, layer: replay.layers[0], threshold: null, compare: false });
    Object.assign(this, { pending: 0, playing: 0, areas: vertexAreas(replay), watchers: [] });
    this.build();
    const { centre, size } = boxOf(this.outline());
    this.camera = new Camera(centre, size);
    try {
      this.scene = new Scene(this.canvas, replay);
    } catch (problem) {
      this.stage.replaceChildren(element("p", { class: "ms-problem", role: "alert" }, problem.message));
    }
    this.release = steer(this.canvas, this.camera, () => this.refresh());
    this.sizes = new ResizeObserver(() => this.refresh());
    this.sizes.observe(this.stage);
    this.refresh();
  }

  outline() { return this.replay.positions; } // what is brought into view
  get framesPerSecond() { return 24; }
  get end() { return this.replay.frames.length - 1; } // where playing stops
  get iteration() { return this.replay.frames[this.frame].iteration; }

  // ---- elements

  build() {
    this.canvas = element("canvas", { class: "ms-canvas", tabindex: "0", role: "img", "aria-label": "The part in three dimensions", title: "" });
    this.names = element("div", { class: "ms-names", "aria-hidden": "true" });
    this.stage = element("div", { class: "ms-stage" }, this.canvas, this.names);
    this.caption = element("p", { class: "ms-caption", "aria-live": "polite" });
    this.root.classList.add("ms-player");
    this.root.replaceChildren(this.toolbar(), this.stage, this.scrubber(), this.caption, this.help(), this.legend());
    this.keys = (event) => this.key(event);
    this.root.addEventListener("keydown", this.keys);
  }

  toolbar() {
    this.buttons = this.replay.layers.map((layer) => {
      const button = element("button", { type: "button", role: "radio", "aria-checked": "false" }, layer.title);
      button.onclick = () => this.choose(layer.key);
      return button;
    });
    const layers = element("div", { class: "ms-segments", role: "radiogroup", "aria-label": "Layer" }, ...this.buttons);
    this.beside = element("button", { type: "button", class: "ms-plain", "aria-pressed": "false" }, "Beside the original");
    this.beside.onclick = () => this.besides(!this.compare);
    const reset = element("button", { type: "button", class: "ms-plain" }, "Reset view");
    reset.onclick = () => { this.camera.reset(); this.refresh(); };
    return element("div", { class: "ms-toolbar" }, layers, element("span", { class: "ms-right" }, this.beside, reset));
  }

  legend() {
    this.bar = element("div", { class: "ms-bar", "aria-hidden": "true" });
    this.ticks = element("div", { class: "ms-ticks" });
    this.label = element("div", { class: "ms-label" });
    this.knob = element("input", { type: "range", step: "any", class: "ms-knob", "aria-label": "Threshold" });
    this.knob.oninput = () => { this.threshold = Number(this.knob.value); this.refresh(); this.tell(); };
    this.scale = element("div", { class: "ms-legend" }, this.label, this.bar, this.knob, this.ticks);
    return this.scale;
  }

  scrubber() {
    this.play = element("button", { type: "button", class: "ms-play", "aria-label": "Play" }, "▶");
    this.play.onclick = () => this.toggle();
    this.slider = element("input", { type: "range", min: "0", max: String(this.replay.frames.length - 1), step: "1", "aria-label": "Iteration" });
    this.slider.oninput = () => this.to(Number(this.slider.value));
    this.count = element("output", { class: "ms-count" });
    return element("div", { class: "ms-scrub" }, this.play, this.slider, this.count);
  }

  get keysHelp() { return KEYS_HELP; }

  help() {
    return element("details", { class: "ms-help" }, element("summary", {}, "Mouse and keys"), element("p", {}, this.keysHelp));
  }

  // ---- what a person does

  tell() {
    const { iteration, threshold } = this;
    this.changed({ iteration, layer: this.layer.key, threshold });
  }

  to(frame) {
    this.frame = Math.min(Math.max(frame, 0), this.replay.frames.length - 1);
    this.refresh();
    this.tell();
  }

  choose(key) {
    this.layer = this.replay.layers.find((layer) => layer.key === key);
    this.threshold = this.layer.threshold;
    this.describeScale(); // at once: the knob must not clip what is set on it to the range of the last layer
    this.refresh();
    this.tell();
  }

  besides(compare) {
    this.compare = compare;
    this.refresh();
  }

  goTo(iteration) {
    this.to(Math.max(this.replay.frames.findLastIndex((frame) => frame.iteration <= iteration), 0));
  }

  simulation(direction) {
    const { frames } = this.replay;
    for (let at = this.frame + direction; at >= 0 && at < frames.length; at += direction) if (frames[at].outcome) return this.to(at);
  }

  toggle() {
    if (this.playing) return this.pause();
    if (this.frame >= this.end) this.to(0);
    const start = performance.now(), from = this.frame;
    const tick = (now) => {
      const frame = from + Math.floor(((now - start) * this.framesPerSecond) / 1000);
      if (frame > this.frame) this.to(Math.min(frame, this.end));
      this.playing = this.frame < this.end ? requestAnimationFrame(tick) : 0;
      this.refresh();
    };
    this.playing = requestAnimationFrame(tick);
  }

  pause() {
    cancelAnimationFrame(this.playing);
    this.playing = 0;
    this.refresh();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const typed = event.key, onControl = event.target.closest("input, button, summary");
    if (typed === " " && !onControl) this.toggle();
    else if (typed === "n") this.simulation(1);
    else if (typed === "p") this.simulation(-1);
    else if (typed === "o") this.besides(!this.compare);
    else if (this.replay.layers[Number(typed) - 1]) this.choose(this.replay.layers[Number(typed) - 1].key);
    else return;
    event.preventDefault();
    event.stopPropagation(); // a notebook has keys of its own
  }

  // ---- what is shown

  // Brings everything to a state set elsewhere, without telling of it.
  show({ iteration, layer, threshold }) {
    this.frame = Math.max(this.replay.frames.findLastIndex((frame) => frame.iteration <= iteration), 0);
    this.layer = this.replay.layers.find((one) => one.key === layer);
    this.threshold = threshold;
    this.refresh();
  }

  // At most one drawing for each picture of the screen, of the newest state.
  refresh() {
    this.pending ||= requestAnimationFrame(() => { this.pending = 0; this.draw(); });
  }

  draw() {
    const sharp = window.devicePixelRatio || 1, { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.scene && width && height) {
      const [wide, high] = [Math.round(width * sharp), Math.round(height * sharp)];
      if (this.canvas.width !== wide || this.canvas.height !== high) Object.assign(this.canvas, { width: wide, height: high });
      this.scene.draw(this.camera, this);
    }
    this.describe();
    for (const watch of this.watchers) watch(this);
  }

  describe() {
    const frame = this.replay.frames[this.frame];
    this.slider.value = String(this.frame);
    this.slider.setAttribute("aria-valuetext", this.named(frame));
    this.count.textContent = this.counted(frame);
    this.play.textContent = this.playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.beside.setAttribute("aria-pressed", String(this.compare));
    this.buttons.forEach((button, place) => button.setAttribute("aria-checked", String(this.replay.layers[place] === this.layer)));
    this.names.replaceChildren(...(this.compare ? ["original", `iteration ${frame.iteration}`] : []).map((name) => element("span", {}, name)));
    this.caption.textContent = this.sentence(frame);
    this.describeScale();
  }

  named(frame) { return `iteration ${frame.iteration}`; }
  counted(frame) { return `${frame.iteration} / ${this.replay.frames.at(-1).iteration}`; }

  sentence(frame) {
    if (frame.outcome === undefined) return `Iteration ${frame.iteration}: not simulated; stress, bend and mask are those of iteration ${frame.simulatedAt}.`;
    return `Iteration ${frame.iteration}: ${frame.words}. Simulated because: ${frame.reason}.`;
  }

  describeScale() {
    const { label, unit, low, high, key, bounded } = this.layer, split = this.threshold !== null;
    this.scale.classList.toggle("ms-away", key === "style");
    this.knob.classList.toggle("ms-away", !split);
    if (key === "style") return;
    const place = split ? Math.min(Math.max((this.threshold - low) / (high - low), 0), 1) : 1;
    Object.assign(this.knob, { min: low, max: high, value: this.threshold ?? high });
    this.knob.setAttribute("aria-valuetext", split ? withUnit(this.threshold, unit) : "none");
    this.label.textContent = (unit ? `${label} [${unit}]` : label) + (split ? ` · ${this.shareAbove()} above ${withUnit(this.threshold, unit)}` : "");
    this.bar.style.background = this.gradient(place);
    this.ticks.replaceChildren(element("span", {}, shown(low)), element("span", {}, (bounded ? "≥ " : "") + shown(high)));
  }

  shareAbove() {
    const { low, step } = this.replay.channels[this.layer.key], raw = plane(this.replay, this.layer.key, this.frame);
    let [above, all] = [0, 0];
    for (let i = 0; i < raw.length; i++) {
      all += this.areas[i];
      if (raw[i] < 65535 && low + step * raw[i] > this.threshold) above += this.areas[i];
    }
    return `${((100 * above) / all).toFixed(1)} % of the surface`;
  }

  // The ramp up to the threshold, then the hatch the surface has above it.
  gradient(place) {
    const { ramp, above, stripe } = this.replay.colours;
    const stops = Array.from({ length: 17 }, (_, k) => `${css(ramp.slice(3 * k * 15, 3 * k * 15 + 3))} ${((100 * place * k) / 16).toFixed(2)}%`);
    const hatch = `repeating-linear-gradient(135deg, ${css(stripe)} 0 2px, ${css(above)} 2px 6px)`;
    return `linear-gradient(to right, ${stops.join(", ")}, transparent ${(100 * place).toFixed(2)}%), ${hatch}`;
  }

  dispose() {
    cancelAnimationFrame(this.pending);
    cancelAnimationFrame(this.playing);
    this.release();
    this.sizes.disconnect();
    this.root.removeEventListener("keydown", this.keys);
    this.scene?.dispose();
    this.root.replaceChildren();
  }
}
