// What only the page knows of a Studio: how much room it has, whether the theme is dark, which key was pressed, the whole screen;
// and what only a page can do: hand a file over.

const LEAST = 320, BELOW = 12; // least height of a view in the full window, and what it leaves for the head of the timeline under its scale [px]
const QUIET = 120; // a size counts when it has stood still for so long [ms]
const IN_VIEW = ["+", "-", "=", "Home", "Enter", "PageUp", "PageDown"], ANYWHERE = [..."rn.>c123456amxoliwpzy"];
const ROOTS = ".mechstyle-studio, .mechstyle-alone";
const KEYS = { // the list that `?` opens
  "anywhere but in a field": [
    ["R", "run, or go on; in a field Ctrl with Enter"], [".", "one iteration"], ["Shift with .", "on to the next drop test"],
    ["1 to 6, L", "style, stress, what stays bent, restraint, demand, displacement; the next layer"],
    ["C, N", "compare with the iteration on show, branch from it"], ["I", "the impact, and back"], ["W", "what another setting would hold back"],
    ["Z, Y", "undo the last setting, redo it"], ["X, O, M, A, P", "cut open, look in parallel, measure, keep places, paint"], ["F", "full window, and back"],
    ["?", "this list"], ["Escape", "closes this list; goes back from a page of settings; leaves the tool, then the measure, then the cut"],
  ],
  "in the view": [
    ["arrows", "turn the part by 15°, with Ctrl by 1°; with Shift move it"], ["+, −, Home", "nearer, farther, all of it"],
    ["Shift with 1 to 5", "front, side, top, below, three quarter"], ["Enter", "a click on what is under the cross in the middle"],
    ["Page Up, Page Down", "move the cut"], ["Space", "pause"],
  ],
  "on the slider under it": [["arrows, Page Up, Page Down", "step from iteration to iteration"], ["Home, End", "the first, the last"]],
  "everywhere": [["Tab", "from control to control; a grid of pictures is one stop, in which the arrows move"]],
};
const FIELDS = "input:not([type=range], [type=checkbox]), textarea, select, [contenteditable]";

const LOST = "Error displaying widget: model not found", VIEW = "application/vnd.jupyter.widget-view+json";
const AGAIN = Symbol.for("mechstyle.again"); // each widget has a module of its own: what is the page's stands with the page
const LOOK = 500, LONG = 60_000; // between two looks, and how long after this model all others are there and their views have given up [ms]

// JupyterLab looks for the model of a view for two seconds. If the page is so busy with making models that the time is over before it
// looks once more, the view says for good that there is none. Being shown its output anew, it finds it.
function recover(manager) {
  if (!manager.context) return; // no notebook
  const end = Date.now() + LONG, lost = ({ firstChild }) => firstChild?.nodeType === Node.TEXT_NODE && firstChild.data === LOST;
  (function look() {
    if ([...document.querySelectorAll(".jupyter-widgets")].some(lost)) showAgain(manager);
    if (Date.now() < end) setTimeout(look, LOOK);
  })();
}

// All views of a model, once: which of them gave up is not told, and from now on each finds it.
function showAgain(manager) {
  const again = (globalThis[AGAIN] ??= new Set()), found = new Set();
  for (const { outputs } of manager.context.model.cells) {
    for (let at = 0; at < (outputs?.length ?? 0); at++) {
      const output = outputs.get(at), id = output.data[VIEW]?.model_id;
      if (!id || again.has(id) || !manager.has_model(id)) continue;
      outputs.set(at, output.toJSON());
      found.add(id);
    }
  }
  found.forEach((id) => again.add(id));
}

// What the kernel said while this page made its models had nobody to hear it: once all are made, it is said again.
async function catchUp(model) {
  const { restored, restoredStatus } = model.widget_manager;
  if (restoredStatus === false) await new Promise((done) => restored.connect(done));
  model.send({ kind: "made" });
}

let say = (english) => english; // in another language, where the kernel speaks one

function initialize({ model }) {
  say = speaking(model);
  recover(model.widget_manager);
  catchUp(model);
  model.on("msg:custom", (message, buffers) => {
    if (message.kind === "text") navigator.clipboard?.writeText(message.text).catch(() => {}); // the page shows it as well
    if (message.kind === "news" && document.hidden && globalThis.Notification?.permission === "granted") new Notification(message.text);
    if (message.kind !== "file") return;
    const address = URL.createObjectURL(new Blob(buffers, { type: message.type }));
    const link = Object.assign(document.createElement("a"), { href: address, download: message.name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(address), 60_000);
  });
}

function render({ model, el }) {
  const undo = [];
  const listen = (target, kind, act) => {
    target.addEventListener(kind, act);
    undo.push(() => target.removeEventListener(kind, act));
  };
  const watch = (observer, target, options) => {
    observer.observe(target, options);
    undo.push(() => observer.disconnect());
  };
  let frame = requestAnimationFrame(function attach() {
    const root = el.closest(ROOTS);
    if (root) begin(root, root.matches(".mechstyle-studio"));
    else frame = requestAnimationFrame(attach); // it is not in the page at once
  });
  undo.push(() => cancelAnimationFrame(frame));

  function begin(root, studio) {
    if (!studio && root.parentElement.closest(ROOTS)) return; // what it stands in has a frame of its own
    const name = () => label(root);
    watch(new MutationObserver(name), root, { childList: true, subtree: true, attributes: true, attributeFilter: ["class"] });
    name();
    undo.push(explain(root, model.get("terms"))); // before the keys: Escape closes what is explained first
    listen(root, "keydown", (event) => pressed(model, root, event));
    holdFocus(root, listen, watch);
    undo.push(tellOfTheEnd(model, root));
    if (!studio) return;
    el.append(button(HELP, () => help(root)), button(FULL, () => full(root)));
    if (model.get("filled")) full(root);
    const stage = root.querySelector(".mechstyle-view");
    let timer = 0;
    const measure = () => {
      clearTimeout(timer);
      timer = setTimeout(() => tell(model, root, stage), QUIET);
    };
    watch(new ResizeObserver(measure), stage);
    undo.push(() => clearTimeout(timer));
    listen(root, "mechstyle-full", measure);
    takeFiles(model, stage, listen);
    listen(root.querySelector(".mechstyle-run"), "click", () => { // a long run may end while nobody looks
      if (globalThis.Notification?.permission === "default") Notification.requestPermission();
    });
    const light = () => {
      model.set("dark", document.body.dataset.jpThemeLight ? document.body.dataset.jpThemeLight === "false" : matchMedia("(prefers-color-scheme: dark)").matches);
      model.set("calm", matchMedia("(prefers-reduced-motion: reduce)").matches);
      model.save_changes();
    };
    watch(new MutationObserver(light), document.body, { attributes: true, attributeFilter: ["data-jp-theme-light"] });
    light();
  }
  return () => undo.forEach((end) => end());
}

// Once the kernel is gone nothing here is heard: that is said once, instead of a broken link at every control.
function tellOfTheEnd(model, root) {
  const words = Object.assign(document.createElement("div"), { className: "mechstyle-was", textContent: model.get("was") });
  words.setAttribute("role", "status");
  let found = null;
  const look = () => {
    const gone = !found.comm_live;
    root.classList.toggle("mechstyle-gone", gone);
    for (const part of root.children) part.inert = gone;
    gone ? root.prepend(words) : words.remove();
    words.inert = false;
  };
  model.widget_manager.get_model(model.get("own")).then((one) => {
    found = one;
    found.on("comm_live_update", look);
    if (!found.comm_live) look();
  }).catch(() => {}); // a host with models of its own sort
  return () => {
    found?.off("comm_live_update", look);
    words.remove();
  };
}

// What is pressed may go out of reach, as Run does while it runs: the focus would go to the page, where no key is heard. It stays here.
function holdFocus(root, listen, watch) {
  let held = null; // has the focus, or had it until it went out of reach
  const lost = () => !held.isConnected || held.disabled;
  listen(root, "focusin", ({ target }) => (held = target));
  listen(root, "focusout", ({ target }) => setTimeout(() => { // by then it is known whether it went out of reach
    if (held === target && !lost() && document.activeElement !== held) held = null; // another window leaves it where it is
  }));
  const keep = () => {
    if (!held || !lost() || ![held, document.body].includes(document.activeElement)) return;
    root.tabIndex = -1;
    root.focus({ preventScroll: true });
  };
  watch(new MutationObserver(keep), root, { childList: true, subtree: true, attributes: true, attributeFilter: ["disabled"] });
}

// A file that is dropped on the view is the part from then on; anywhere else the page would go to it.
function takeFiles(model, stage, listen) {
  const over = (on) => (event) => {
    if (![...event.dataTransfer.types].includes("Files")) return;
    event.preventDefault();
    event.stopPropagation();
    stage.classList.toggle("mechstyle-drop", on);
  };
  listen(stage, "dragover", over(true));
  listen(stage, "dragleave", over(false));
  listen(stage, "drop", async (event) => {
    over(false)(event);
    const [file] = event.dataTransfer.files;
    if (file) model.send({ kind: "dropped", name: file.name }, undefined, [await file.arrayBuffer()]);
  });
}

function tell(model, root, stage) {
  const width = Math.round(stage.clientWidth);
  if (!width) return; // hidden: it keeps its size
  let height = Math.min(Math.max(360, 0.51 * width), 560);
  if (root.matches(".mechstyle-window")) {
    const top = (stage.querySelector("canvas") ?? stage).getBoundingClientRect().top + stage.parentElement.scrollTop;
    const under = [".mechstyle-under", ".mechstyle-moments"].reduce((sum, one) => sum + (stage.querySelector(one)?.offsetHeight ?? 0), 0);
    height = Math.max(LEAST, root.clientHeight - top - under - BELOW);
  }
  model.set("size", [width, Math.round(height)]);
  model.save_changes();
}

const FULL = ["mechstyle-full", "Full window", "Full window, and back (F)", "M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4"];
const HELP = ["mechstyle-help", "Keys", "What the keys do (?)", "M5 6a3 3 0 1 1 4.2 2.7Q8 9.3 8 11M8 13v1.2"];

function button([className, words, title, path], act) {
  const made = Object.assign(document.createElement("button"), { className, title: say(title) });
  made.setAttribute("aria-label", say(words));
  made.innerHTML = `<svg viewBox="0 0 16 16" aria-hidden="true"><path d="${path}"/></svg>`;
  made.addEventListener("click", act); // here: a busy kernel would let it wait
  return made;
}

// Open the list of keys, or close it; the focus goes back to where it was.
function help(root) {
  const open = root.querySelector(".mechstyle-keys");
  if (open) {
    open.remove();
    open.before.focus();
    return;
  }
  const panel = Object.assign(document.createElement("div"), { className: "mechstyle-keys", tabIndex: -1 });
  panel.setAttribute("role", "dialog");
  panel.setAttribute("aria-label", say("What the keys do"));
  const rows = (keys) => keys.map(([key, does]) => `<tr><th scope="row">${say(key)}</th><td>${say(does)}</td></tr>`).join("");
  panel.innerHTML = Object.entries(KEYS).map(([where, keys]) => `<table><caption>${say(where)}</caption>${rows(keys)}</table>`).join("");
  panel.before = document.activeElement;
  panel.prepend(button(["mechstyle-close", "Close", "Close (Escape)", "M3 3l10 10M13 3L3 13"], () => help(root)));
  root.append(panel);
  panel.focus();
}

// All of the page for the Studio, or its cell again: in the layer over all others, where nothing that it stands in cuts it off.
function full(root) {
  if (root.classList.toggle("mechstyle-window")) {
    root.popover = "manual";
    root.showPopover();
  } else root.popover = null;
  root.dispatchEvent(new Event("mechstyle-full"));
}

// Names and states that ipywidgets has no words for.
function label(root) {
  for (const canvas of root.querySelectorAll(".mechstyle-stage canvas:not([tabindex])")) {
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", say("The part: arrow keys turn it, plus and minus come nearer and go farther, Home shows all of it, Enter asks about the place in the middle"));
  }
  for (const image of root.querySelectorAll("img:not([alt])")) image.alt = ""; // what it shows stands in words beside it
  for (const head of root.querySelectorAll(".mechstyle-group-head")) {
    const open = head.classList.contains("mechstyle-open"), opened = open && head.getAttribute("aria-expanded") === "false";
    set(head, "aria-expanded", open);
    if (opened) head.scrollIntoView({ block: "nearest" }); // what is opened is seen, wherever the column stood
  }
  for (const one of root.querySelectorAll("button.widget-toggle-button")) set(one, "aria-pressed", one.classList.contains("mod-active"));
  for (const one of root.querySelectorAll("button.mechstyle-pin")) set(one, "aria-label", one.title);
  for (const one of root.querySelectorAll("button[title]:not([aria-label])")) if (!one.textContent.trim()) one.setAttribute("aria-label", one.title);
  for (const play of root.querySelectorAll(".widget-play")) {
    const [go, stop] = play.querySelectorAll("button");
    set(go, "aria-label", say("Play"));
    set(stop, "aria-label", say("Back to the start"));
  }
  for (const upload of root.querySelectorAll(".widget-upload")) { // ipywidgets counts what was read
    for (const text of upload.childNodes) if (text.nodeType === Node.TEXT_NODE && / \(\d+\)$/.test(text.data)) text.data = text.data.replace(/ \(\d+\)$/, "");
  }
  for (const handle of root.querySelectorAll(".noUi-handle:not([aria-label])")) {
    const words = handle.closest(".widget-slider, .jupyter-widgets")?.querySelector("label, .widget-label")?.textContent;
    handle.setAttribute("aria-label", words || handle.closest("[title]")?.title || say("slider"));
  }
}

function set(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

// No key but those with Ctrl, Meta or Alt, and Shift+Enter, goes on to the notebook, where `b` inserts a cell.
function pressed(model, root, event) {
  const { target } = event, goes = event.ctrlKey && event.key === "Enter" && target.closest(".mechstyle-setup") && target.closest(FIELDS);
  if (!goes && (event.metaKey || event.altKey || (event.ctrlKey && !event.key.startsWith("Arrow")) || (event.shiftKey && event.key === "Enter"))) return;
  event.stopPropagation();
  if (goes) {
    event.preventDefault();
    target.blur(); // what is written counts when the field is left
    target.focus();
    model.send({ kind: "studio", key: "r" });
  }
  if (target.closest(FIELDS) || event.defaultPrevented) return;
  const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
  if (target.tagName === "CANVAS" && (event.key.startsWith("Arrow") || IN_VIEW.includes(event.key) || (event.shiftKey && digit))) {
    event.preventDefault();
    model.send({ kind: "view", key: event.shiftKey && digit ? digit : event.key, shift: event.shiftKey, ctrl: event.ctrlKey });
  } else if (event.key.startsWith("Arrow") && target.closest(".mechstyle-pictures")) {
    event.preventDefault();
    step(target, ["ArrowRight", "ArrowDown"].includes(event.key) ? 1 : -1);
  } else if (event.key === "?" || (event.key === "Escape" && root.querySelector(".mechstyle-keys"))) {
    help(root);
  } else if (event.key === " " && target.tagName === "CANVAS") {
    event.preventDefault();
    model.send({ kind: "studio", key: " " });
  } else if (!event.ctrlKey && !event.shiftKey && event.key.toLowerCase() === "f") {
    full(root);
  } else if (!event.ctrlKey) {
    const key = event.shiftKey && event.code === "Period" ? ">" : event.key.toLowerCase();
    if (key === "escape" || ANYWHERE.includes(key)) model.send({ kind: "studio", key: key === "escape" ? "Escape" : key });
  }
}

function step(from, by) {
  const all = [...from.closest(".mechstyle-pictures").querySelectorAll("button")].filter((one) => one.offsetParent);
  all[(all.indexOf(from) + by + all.length) % all.length]?.focus();
}

export default { initialize: hears(initialize), render };
