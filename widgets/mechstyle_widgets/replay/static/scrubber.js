// The slider over iterations. While it is dragged the page itself fills the buffers of the view, from the iterations it holds;
// the kernel is told where the slider rests, and what the kernel then draws takes the place of what stood in for it.

import { pose, plane, unpack } from "./replay_data.js";

const FRAME = 1000 / 24; // of playing [ms]

function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const reference = (text) => text.replace("IPY_MODEL_", "");

// The buffers of a view, lent to the page.
class Loan {
  constructor(manager, page) {
    Object.assign(this, { page, taken: false });
    const ids = { view: page.view, material: page.material, ...page.buffers };
    const names = Object.keys(ids);
    this.ready = Promise.all(names.map((name) => manager.get_model(ids[name]))).then((found) => {
      this.models = Object.fromEntries(names.map((name, k) => [name, found[k]]));
    });
    this.ready.catch(() => {}); // a view that was closed meanwhile
  }

  own(name, make) {
    this.arrays ??= {};
    return (this.arrays[name] ??= make());
  }

  fill(name, array) {
    const { obj } = this.models[name];
    if (obj.array !== array) obj.setArray(array);
    obj.needsUpdate = true;
  }

  show(replay, frame, codes) {
    const triples = () => new Float32Array(replay.positions.length);
    const positions = this.own("position", triples), normals = this.own("normal", triples);
    pose(replay, frame, positions, normals);
    this.fill("position", positions);
    this.fill("normal", normals);
    const colours = this.own("colour", triples), bytes = plane(replay, "colour", frame);
    for (let i = 0; i < bytes.length; i++) colours[i] = bytes[i] / 255;
    this.fill("colour", colours);
    if (this.page.layer !== "style") this.fill("place", placed(replay, this.page.layer, frame, codes, this.own("place", () => new Float32Array(replay.vertices))));
    this.fill("kind", this.own("kind", () => new Float32Array(this.models.kind.obj.array.length).fill(codes.hidden))); // marks belong to what the kernel drew
    this.models.material.obj.visible = true;
    this.taken = true;
    this.draw();
  }

  // What the kernel has told the models is shown again.
  giveBack() {
    if (!this.taken) return;
    this.taken = false;
    for (const name of Object.keys(this.page.buffers)) this.models[name].mapBufferAttributeArrayModelToThree();
    for (const name of Object.keys(this.models)) if (name === "material" || name.startsWith("look")) this.models[name].obj.visible = this.models[name].get("visible");
    this.draw();
  }

  draw() { this.models.view.trigger("rerender", this.models.view, {}); }
}

// Paint codes of a field at a frame, as the view has them: places on the ramp, apart from those of a field without a threshold.
function placed(replay, key, frame, codes, out) {
  const layer = replay.layers.find((one) => one.key === key), { low: base, step } = replay.channels[key], raw = plane(replay, key, frame);
  let { low, high } = layer;
  if (layer.low === -layer.high) high = -(low = -reach(replay, key, frame)); // both sides of zero: as far as this one and the last go
  const top = (key === "stress" ? limitAt(replay, frame) : undefined) ?? layer.threshold ?? high;
  for (let i = 0; i < raw.length; i++) {
    const place = (base + step * raw[i] - low) / (top - low);
    out[i] = raw[i] === codes.noNumber ? codes.nothing : layer.threshold === null ? codes.open + Math.min(Math.max(place, 0), 1) : Math.min(Math.max(place, 0), 10);
  }
  return out;
}

// What stress may at most be at a frame: each verdict has a limit of its own, and the view shows the newest.
function limitAt(replay, frame) {
  return replay.frames.slice(0, frame + 1).findLast((one) => one.limit !== undefined)?.limit;
}

function reach(replay, key, frame) {
  const { low, step } = replay.channels[key], reaches = (replay.reaches ??= new Map());
  const of = (at) => {
    const raw = plane(replay, key, at);
    if (!reaches.has(raw)) {
      let most = 0;
      for (const one of raw) most = Math.max(most, Math.abs(low + step * one));
      reaches.set(raw, most);
    }
    return reaches.get(raw);
  };
  return Math.max(of(frame), of(replay.frames.length - 1)) || 1;
}

function render({ model, el }) {
  const say = speaking(model);
  const slider = element("input", { type: "range", min: "0", step: "1", "aria-label": say("iteration"), title: say("Arrow keys: left and right step, up and down choose a lane") });
  const button = element("button", { type: "button", class: "mechstyle-play", "aria-label": say("Play"), title: say("Play, and stop") }, "▶");
  const count = element("output", { class: "mechstyle-count" });
  slider.dataset.lmSuppressShortcuts = button.dataset.lmSuppressShortcuts = "true"; // not the notebook's keys
  el.classList.add("mechstyle-scrubber");
  el.append(button, element("span", { class: "mechstyle-scrubber-label", "aria-hidden": "true" }, say("iteration")), slider, count);
  let replay = null, loan = null, held = false, resting = 0, playing = 0, closed = false;

  const listeners = [];
  const on = (names, act) => { model.on(names, act); listeners.push([names, act]); };
  const root = () => el.closest(".mechstyle-studio") ?? el.closest(".mechstyle-timeline")?.parentElement;
  const codes = () => model.get("_page").codes;

  // ---- what is shown

  const said = () => {
    const at = Number(slider.value), frame = frameOf(at);
    count.textContent = say("{} of {}", at, model.get("max"));
    const tested = frame?.outcome ? `, ${frame.words}` : "";
    slider.setAttribute("aria-valuetext", say("iteration {} of {}", at, model.get("max")) + tested);
  };
  const frameOf = (at) => (replay && model.get("_served").includes(at) ? replay.frames.find((frame) => frame.iteration === at) : undefined);
  const passing = (is) => root()?.classList.toggle("mechstyle-passing", is); // what is said of the iteration before grows pale

  const head = (at) => { // the line in the timeline, which the kernel moves only at rest
    const plot = el.closest(".mechstyle-timeline")?.querySelector(".js-plotly-plot"), line = plot?.querySelector(".shapelayer path"), shape = plot?._fullLayout?.shapes?.[0];
    const axis = plot?._fullLayout?.xaxis;
    if (line && shape && axis) line.setAttribute("transform", `translate(${axis.d2p(at) - axis.d2p(shape.x0)} 0)`);
  };

  const standing = () => {
    if (held || playing) return;
    slider.max = String(model.get("max")); // before the value, which is cut off at it
    slider.value = String(model.get("value"));
    slider.disabled = button.disabled = model.get("max") < 1;
    said();
  };

  const settled = () => {
    const page = model.get("_page");
    if (held || playing || page.drawn !== Number(slider.value)) return;
    loan?.giveBack();
    passing(false);
  };

  // ---- what a person does

  const rest = () => {
    clearTimeout(resting);
    held = false;
    if (model.get("value") !== Number(slider.value)) {
      model.set("value", Number(slider.value));
      model.save_changes();
    }
    settled();
  };

  let asked = 0;
  const moved = () => {
    said();
    cancelAnimationFrame(asked);
    asked = requestAnimationFrame(() => {
      const at = Number(slider.value), frame = frameOf(at);
      if (frame && loan?.models) {
        const began = performance.now();
        loan.show(replay, replay.frames.indexOf(frame), codes());
        head(at);
        el.dispatchEvent(new CustomEvent("mechstyle-scrubbed", { detail: { iteration: at, took: performance.now() - began }, bubbles: true }));
      }
      if (!frame || !loan?.models || model.get("_live")) { // it is the kernel that draws
        if (model.get("value") !== at) { model.set("value", at); model.save_changes(); }
      } else passing(true);
    });
  };

  const input = () => {
    stop();
    moved();
    clearTimeout(resting);
    if (!held) resting = setTimeout(rest, model.get("rest")); // keys
  };
  slider.addEventListener("pointerdown", () => { held = true; });
  slider.addEventListener("input", input);
  slider.addEventListener("keydown", (event) => { // left and right step along a lane, up and down from lane to lane as they stand above
    const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!by || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    model.send({ kind: "lane", by });
  });
  for (const name of ["pointerup", "pointercancel"]) slider.addEventListener(name, () => held && rest());

  const stop = () => {
    if (!playing) return;
    cancelAnimationFrame(playing);
    playing = 0;
    button.textContent = "▶";
    button.setAttribute("aria-label", say("Play"));
  };
  const play = () => {
    if (playing) { stop(); rest(); return; }
    const last = Number(slider.max), from = Number(slider.value) >= last ? 0 : Number(slider.value), began = performance.now();
    button.textContent = "❚❚";
    button.setAttribute("aria-label", say("Stop"));
    const next = () => {
      const at = Math.min(from + Math.floor((performance.now() - began) / FRAME), last);
      if (at !== Number(slider.value)) { slider.value = String(at); moved(); }
      if (at < last) playing = requestAnimationFrame(next);
      else { stop(); requestAnimationFrame(rest); }
    };
    playing = requestAnimationFrame(next);
  };
  button.addEventListener("click", play);

  // ---- what the kernel tells

  const open = async () => {
    const named = model.get("_cache");
    if (!named) { replay = null; return; }
    const cache = await model.widget_manager.get_model(reference(named)), { buffer, byteOffset, byteLength } = cache.get("_payload");
    const found = await unpack(cache.get("_header"), new Uint8Array(buffer, byteOffset, byteLength));
    if (closed || model.get("_cache") !== named) return;
    replay = found;
    el.dataset.ready = String(model.get("_served").length);
    said();
  };
  const borrow = () => {
    const page = model.get("_page");
    el.dataset.drawn = `${page.layer} ${page.drawn}`;
    if (!page.view) { loan?.giveBack(); loan = null; return; }
    const same = loan && JSON.stringify({ ...loan.page, drawn: 0 }) === JSON.stringify({ ...page, drawn: 0 });
    if (!same) { loan?.giveBack(); loan = new Loan(model.widget_manager, page); }
    settled();
  };
  const opened = () => open().catch(() => { replay = null; }); // without it the kernel draws every iteration
  on("change:_cache", opened);
  on("change:_served", () => { el.dataset.ready = String(replay ? model.get("_served").length : 0); });
  on("change:_page", borrow);
  on("change:value change:max", standing);
  standing();
  borrow();
  opened();
  return () => {
    closed = true;
    stop();
    clearTimeout(resting);
    cancelAnimationFrame(asked);
    for (const [names, act] of listeners) model.off(names, act);
    loan?.giveBack();
  };
}

export default { initialize: hears(), render };
