// Starts the replay of a report and links the timeline and the tables with it.

import { unpack, unpackImpact } from "./replay_data.js";
import { Player } from "./player.js";
import { ImpactPlayer } from "./impact.js";

const text = (id) => document.getElementById(id).textContent;
const bytesOf = (base64) => Uint8Array.fromBase64?.(base64) ?? Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

// Marks and rows name their iteration; a click or Enter on one moves the replay, and the replay moves the marker.
function link(player) {
  for (const mark of document.querySelectorAll("[data-iteration]")) {
    const go = () => player.goTo(Number(mark.dataset.iteration));
    mark.addEventListener("click", (event) => { event.stopPropagation(); go(); });
    mark.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      go();
    });
  }
  const chart = document.querySelector("svg.timeline"), cursor = chart.querySelector(".cursor"), { left, right, last } = chart.dataset;
  const across = (iteration) => Number(left) + ((Number(right) - Number(left)) * iteration) / Number(last);
  chart.addEventListener("click", (event) => {
    const box = chart.getBoundingClientRect(), x = ((event.clientX - box.left) / box.width) * chart.viewBox.baseVal.width;
    player.goTo(Math.round(((x - left) / (right - left)) * last));
  });
  chart.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    player.to(player.frame + step);
  });
  player.watchers.push(() => {
    cursor.setAttribute("transform", `translate(${across(player.iteration)} 0)`);
    for (const row of document.querySelectorAll("tr[data-iteration]"))
      row.toggleAttribute("data-current", Number(row.dataset.iteration) === player.iteration);
  });
}

// The impacts take turns in one player: a browser gives few contexts.
async function showImpacts(replay) {
  const root = document.getElementById("impact"), choice = document.getElementById("impact-choice");
  if (!root) return;
  const headers = JSON.parse(text("impact-headers")), payloads = headers.map((_, number) => text(`impact-payload-${number}`));
  let shown = null;
  const show = async () => {
    const impact = await unpackImpact(headers[choice.value], bytesOf(payloads[choice.value]), replay);
    shown?.dispose();
    shown = new ImpactPlayer(root, impact);
  };
  choice.onchange = show;
  await show();
}

async function start() {
  const replay = await unpack(JSON.parse(text("replay-header")), bytesOf(text("replay-payload")));
  document.getElementById("replay-payload").remove(); // the unpacked replay is kept, the text need not be
  const player = new Player(document.getElementById("replay"), replay);
  link(player);
  player.watchers.push(() => { document.body.dataset.ready = player.scene ? "replay" : "still"; });
  await showImpacts(replay);
}

start().catch((problem) => {
  document.getElementById("replay").textContent = `The replay could not be opened: ${problem.message}`;
  throw problem;
});
