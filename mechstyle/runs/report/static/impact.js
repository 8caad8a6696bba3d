// The fall of the part as a film: it opens at the peak, and plays from the air to the shape that stays.

import { Player, element } from "./player.js";
import { plane } from "./replay_data.js";

const FACTORS = [1, 5, 10, 20, 50, 100], USUAL = 20;
const IMPACT_KEYS = "Drag to turn, shift-drag to move, click and scroll to zoom. Keys: arrows turn or scrub, + and − zoom, 0 resets, " +
  "space plays from the air to the shape that stays.";

// The part at a moment: its motion as a whole as it is, its deformation exaggerated.
function struck({ positions: p, channels, frames, exaggeration }, frame, out) {
  const { turn: r, shift: t } = frames[frame], { low, step } = channels.deformation, raw = plane({ channels }, "deformation", frame);
  for (let i = 0; i < p.length; i += 3)
    for (let k = 0; k < 3; k++)
      out[i + k] = r[3 * k] * p[i] + r[3 * k + 1] * p[i + 1] + r[3 * k + 2] * p[i + 2] + t[k] + exaggeration * (low + step * raw[i + k]);
}

export class ImpactPlayer extends Player {
  constructor(root, impact) {
    super(root, Object.assign(impact, { shape: struck, exaggeration: USUAL }));
    this.threshold = this.layer.threshold;
    this.frame = impact.peak;
  }

  outline() {
    const out = new Float32Array(this.replay.positions.length);
    struck(this.replay, this.replay.peak, out);
    return out;
  }
  get framesPerSecond() { return 8; }
  get keysHelp() { return IMPACT_KEYS; }

  toolbar() {
    this.buttons = [];
    this.beside = element("button", { type: "button" }); // an impact stands alone
    const reset = element("button", { type: "button", class: "ms-plain" }, "Reset view");
    reset.onclick = () => { this.camera.reset(); this.refresh(); };
    const peak = element("button", { type: "button", class: "ms-plain" }, "To the peak");
    peak.onclick = () => { this.pause(); this.to(this.replay.peak); };
    const stays = element("button", { type: "button", class: "ms-plain" }, "What stays");
    stays.onclick = () => { this.pause(); this.to(this.end); };
    const factor = element("select", {}, ...FACTORS.map((by) => element("option", { value: String(by) }, `× ${by}`)));
    factor.value = String(USUAL);
    factor.onchange = () => this.exaggerate(Number(factor.value));
    return element("div", { class: "ms-toolbar" }, element("label", {}, "Deformation ", factor), element("span", { class: "ms-right" }, peak, stays, reset));
  }

  scrubber() {
    const made = super.scrubber();
    this.slider.setAttribute("aria-label", "Moment");
    return made;
  }

  exaggerate(factor) {
    this.replay.exaggeration = factor;
    if (this.scene) this.scene.current.frame = -1; // drawn anew
    this.refresh();
  }

  key(event) {
    if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, button, summary, select")) return;
    this.toggle();
    event.preventDefault();
    event.stopPropagation();
  }

  besides() {}
  get over() { return this.frame === this.end; } // at rest in the shape that stays
  named(frame) { return "above" in frame ? this.counted(frame) : this.over ? "at rest" : `${(1000 * frame.time).toFixed(0)} microseconds`; }
  counted(frame) { return "above" in frame ? `${frame.above.toFixed(0)} mm up` : this.over ? "at rest" : `${(1000 * frame.time).toFixed(0)} µs`; }
  sentence(frame) {
    const { name, stays, exaggeration, peak } = this.replay, drawn = `drawn × ${exaggeration}; the floor lies level below.`;
    if ("above" in frame) return `Landing ${name}: it falls from ${this.replay.fall}, ${frame.above.toFixed(0)} mm above the floor.`;
    if (this.over) return `Landing ${name}: ${stays} stays bent, ${drawn} Hatched is what has yielded.`;
    const at = this.frame === peak ? ", the moment of the peak" : "";
    return `Landing ${name}: ${(1000 * frame.time).toFixed(0)} µs after first touch${at}. Deformation ${drawn}`;
  }
}
