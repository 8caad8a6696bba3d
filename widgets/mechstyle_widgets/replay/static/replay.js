// The replay in a notebook: its data is the state of the model, and three traits follow both ways.

import { unpack } from "./replay_data.js";
import { Player, element } from "./player.js";

const FOLLOWED = ["iteration", "layer", "threshold"];

function render({ model, el }) {
  const root = element("div");
  el.append(root);
  let player = null, newest = 0, telling = false;
  const follow = () => {
    if (!telling) player?.show(Object.fromEntries(FOLLOWED.map((name) => [name, model.get(name)])));
  };
  const tell = (state) => {
    telling = true;
    for (const name of FOLLOWED) model.set(name, state[name]);
    telling = false;
    model.save_changes(); // at most one on its way at a time, the newest wins
  };
  const open = async () => {
    const mine = ++newest, { buffer, byteOffset, byteLength } = model.get("_payload");
    const replay = await unpack(model.get("_header"), new Uint8Array(buffer, byteOffset, byteLength));
    if (mine !== newest) return;
    const camera = player?.camera;
    player?.dispose();
    player = new Player(root, replay, tell);
    if (camera) player.camera.take(camera);
    for (const one of root.querySelectorAll("canvas, input, button, summary")) one.dataset.lmSuppressShortcuts = "true"; // not the notebook's keys
    follow();
    root.dataset.ready = player.scene ? "replay" : "still";
  };
  model.on("change:_payload", open);
  for (const name of FOLLOWED) model.on(`change:${name}`, follow);
  open().catch((problem) => root.replaceChildren(element("p", { class: "ms-problem", role: "alert" }, `The replay could not be opened: ${problem.message}`)));
  return () => {
    newest++;
    model.off("change:_payload", open);
    for (const name of FOLLOWED) model.off(`change:${name}`, follow);
    player?.dispose();
  };
}

export default { initialize: hears(), render };
