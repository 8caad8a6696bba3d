// What only the page knows of a Studio: how much room it has, whether the theme is dark, which key was pressed, the whole screen;
// and what only a page can do: hand a file over.

const QUIET = 120; // a size counts when it has stood still for so long [ms]
const IN_VIEW = ["+", "-", "=", "Home", "Enter", "PageUp", "PageDown"], ANYWHERE = [..."rn.c123456amxol"];
const FIELDS = "input:not([type=range], [type=checkbox]), textarea, select, [contenteditable]";

function initialize({ model }) {
  model.on("msg:custom", (message, buffers) => {
    if (message.kind === "text") navigator.clipboard?.writeText(message.text).catch(() => {}); // the page shows it as well
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
    const root = el.closest(".mechstyle-studio");
    if (root) begin(root);
    else frame = requestAnimationFrame(attach); // it is not in the page at once
  });
  undo.push(() => cancelAnimationFrame(frame));

  function begin(root) {
    el.append(button(root));
    const stage = root.querySelector(".mechstyle-view");
    let timer = 0;
    const measure = () => {
      clearTimeout(timer);
      timer = setTimeout(() => tell(model, root, stage), QUIET);
    };
    watch(new ResizeObserver(measure), stage);
    undo.push(() => clearTimeout(timer));
    listen(document, "fullscreenchange", measure);
    const light = () => {
      model.set("dark", document.body.dataset.jpThemeLight ? document.body.dataset.jpThemeLight === "false" : matchMedia("(prefers-color-scheme: dark)").matches);
      model.save_changes();
    };
    watch(new MutationObserver(light), document.body, { attributes: true, attributeFilter: ["data-jp-theme-light"] });
    light();
    const name = () => label(root);
    watch(new MutationObserver(name), root, { childList: true, subtree: true, attributes: true, attributeFilter: ["class"] });
    name();
    listen(root, "keydown", (event) => pressed(model, root, event));
  }
  return () => undo.forEach((end) => end());
}

function tell(model, root, stage) {
  const width = Math.round(stage.clientWidth);
  if (!width) return; // hidden: it keeps its size
  let height = Math.min(Math.max(400, 0.64 * width), 560);
  if (document.fullscreenElement === root) height = Math.max(400, root.clientHeight - (stage.parentElement.scrollHeight - canvasHeight(stage)) - bar(root));
  model.set("size", [width, Math.round(height)]);
  model.save_changes();
}

const canvasHeight = (stage) => stage.querySelector("canvas")?.clientHeight ?? 0;
const bar = (root) => (root.querySelector(".mechstyle-bar")?.offsetHeight ?? 0) + 16;

function button(root) {
  const made = Object.assign(document.createElement("button"), { className: "mechstyle-full", title: "Full screen, and back (F)" });
  made.setAttribute("aria-label", "Full screen");
  made.innerHTML = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4"/></svg>';
  made.addEventListener("click", () => full(root)); // here: by way of a busy kernel the press would be too old
  return made;
}

const full = (root) => (document.fullscreenElement ? document.exitFullscreen() : root.requestFullscreen());

// Names and states that ipywidgets has no words for.
function label(root) {
  for (const canvas of root.querySelectorAll(".mechstyle-stage canvas:not([tabindex])")) {
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", "The part: arrow keys turn it, plus and minus come nearer and go farther, Home shows all of it, Enter asks about the place in the middle");
  }
  for (const head of root.querySelectorAll(".mechstyle-group-head")) set(head, "aria-expanded", head.classList.contains("mechstyle-open"));
  for (const one of root.querySelectorAll("[class*=mechstyle-model-], [class*=mechstyle-style-]")) {
    if (one.tagName === "BUTTON") set(one, "aria-pressed", one.classList.contains("mechstyle-chosen"));
  }
  for (const one of root.querySelectorAll("button.widget-toggle-button")) set(one, "aria-pressed", one.classList.contains("mod-active"));
  for (const one of root.querySelectorAll("button.mechstyle-pin")) set(one, "aria-label", one.title);
  for (const one of root.querySelectorAll("button[title]:not([aria-label])")) if (!one.textContent.trim()) one.setAttribute("aria-label", one.title);
  for (const handle of root.querySelectorAll(".noUi-handle:not([aria-label])")) {
    const words = handle.closest(".widget-slider, .jupyter-widgets")?.querySelector("label, .widget-label")?.textContent;
    handle.setAttribute("aria-label", words || handle.closest("[title]")?.title || "slider");
  }
}

function set(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

// No key but those with Ctrl, Meta or Alt, and Shift+Enter, goes on to the notebook, where `b` inserts a cell.
function pressed(model, root, event) {
  const { target } = event;
  if (event.metaKey || event.altKey || (event.ctrlKey && !event.key.startsWith("Arrow")) || (event.shiftKey && event.key === "Enter")) return;
  event.stopPropagation();
  if (target.closest(FIELDS) || event.defaultPrevented) return;
  const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
  if (target.tagName === "CANVAS" && (event.key.startsWith("Arrow") || IN_VIEW.includes(event.key) || (event.shiftKey && digit))) {
    event.preventDefault();
    model.send({ kind: "view", key: event.shiftKey && digit ? digit : event.key, shift: event.shiftKey, ctrl: event.ctrlKey });
  } else if (event.key.startsWith("Arrow") && target.closest(".mechstyle-pictures")) {
    event.preventDefault();
    step(target, ["ArrowRight", "ArrowDown"].includes(event.key) ? 1 : -1);
  } else if (!event.ctrlKey && !event.shiftKey && event.key.toLowerCase() === "f") {
    full(root);
  } else if (!event.ctrlKey && (event.key === "Escape" || ANYWHERE.includes(event.key.toLowerCase()))) {
    model.send({ kind: "studio", key: event.key === "Escape" ? event.key : event.key.toLowerCase() });
  }
}

function step(from, by) {
  const all = [...from.closest(".mechstyle-pictures").querySelectorAll("button")].filter((one) => one.offsetParent);
  all[(all.indexOf(from) + by + all.length) % all.length]?.focus();
}

export default { initialize, render };
