// Plotly draws what the kernel holds. Its scripts, 5 MB, are no part of a widget's state, which every page that is loaded anew asks for:
// a page asks for them once, when there is something to draw, and keeps them for all figures to come.

const HERE = Symbol.for("mechstyle.plotly"); // each widget has a module of its own: what is the page's stands with the page
const REACH = 20; // of a press to a mark [px]
const CONFIG = { displayModeBar: false, responsive: false };

function library() {
  if (!globalThis[HERE]) {
    const made = (globalThis[HERE] = { there: false });
    made.ready = new Promise((done, fail) => Object.assign(made, { done, fail }));
  }
  return globalThis[HERE];
}

// A module, so that neither `define` nor `module` of the page is taken for a loader it should tell.
function take(script) {
  const plotly = library();
  if (plotly.there) return;
  plotly.there = true;
  const parts = ["const module = { exports: {} };\n", script, "\nexport default module.exports;"];
  const address = URL.createObjectURL(new Blob(parts, { type: "text/javascript" }));
  import(address).then((loaded) => plotly.done(loaded.default), plotly.fail).finally(() => URL.revokeObjectURL(address));
}

function initialize({ model }) {
  model.on("msg:custom", (message, buffers) => {
    if (message.kind === "plotly") take(buffers[0]);
  });
}

// The mark that is pressed. Plotly says of a click only at the release, and nothing if it has drawn in between, as at each iteration of a run.
function nearest(plot, { clientX, clientY }) {
  const { left, top } = plot.getBoundingClientRect(), axes = plot._fullLayout;
  let found = null, least = REACH;
  (plot._fullData ?? []).forEach(({ customdata, x, y, xaxis, yaxis }, trace) => customdata?.forEach((_, point) => {
    const [across, up] = [[xaxis, x], [yaxis, y]].map(([name, at]) => [axes[`${name[0]}axis${name.slice(1)}`], at[point]]);
    const far = Math.hypot(left + across[0]._offset + across[0].d2p(across[1]) - clientX, top + up[0]._offset + up[0].d2p(up[1]) - clientY);
    if (far <= least) [found, least] = [{ trace, point }, far];
  }));
  return found;
}

function render({ model, el }) {
  const plotly = library();
  let Plotly = null, gone = false, pointed = "", from = 0, dragged = false;
  const plot = document.createElement("div"), hint = document.createElement("div");
  hint.className = "mechstyle-hint";
  el.classList.add("mechstyle-curves");
  el.replaceChildren(plot, hint);
  for (const [name, value] of [["role", "slider"], ["tabindex", 0], ["aria-label", speaking(model)("iteration")], ["aria-valuemin", 0]]) plot.setAttribute(name, value);
  plot.style.minHeight = `${model.get("frame").height ?? 0}px`; // nothing moves when it comes
  plot.textContent = plotly.there ? "" : speaking(model)("The curves are drawn as soon as the kernel answers.");

  const layout = () => {
    const { shapes, ...rest } = structuredClone(model.get("frame")), at = model.get("head");
    return { ...rest, shapes: [{ ...shapes[0], x0: at, x1: at }, ...shapes.slice(1)] };
  };
  const draw = () => {
    plot.style.minHeight = `${model.get("frame").height}px`;
    return Plotly.react(plot, structuredClone(model.get("data")), layout(), CONFIG);
  };
  const move = () => {
    const at = model.get("head");
    return Plotly.relayout(plot, { "shapes[0].x0": at, "shapes[0].x1": at });
  };
  const tell = () => {
    hint.innerHTML = model.get("story");
    const value = { "aria-valuemax": model.get("last"), "aria-valuenow": model.get("head"), "aria-valuetext": hint.textContent };
    for (const name in value) plot.setAttribute(name, value[name]);
    if (pointed) hint.innerHTML = pointed;
  };
  // The line is where the mouse holds it, or a key puts it, at once: the kernel hears of it.
  const go = (at) => {
    model.set("head", Math.min(Math.max(Math.round(at), 0), model.get("last")));
    model.save_changes();
  };
  const held = ({ clientX, buttons }) => {
    const axis = plot._fullLayout?.xaxis;
    dragged ||= Math.abs(clientX - from) > 3;
    if (axis && buttons & 1) go(axis.p2d(clientX - plot.getBoundingClientRect().left - axis._offset));
    else removeEventListener("pointermove", held);
  };
  plot.addEventListener("pointerdown", (event) => {
    plot.focus({ preventScroll: true });
    [from, dragged] = [event.clientX, false];
    const mark = nearest(plot, event);
    held(event);
    addEventListener("pointermove", held);
    addEventListener("pointerup", () => {
      if (mark && !dragged) model.send({ kind: "click", ...mark }); // else it is where the line was let go
    }, { once: true });
  });
  plot.addEventListener("keydown", (event) => {
    const far = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10, Home: -Infinity, End: Infinity }[event.key];
    if (far === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    go(model.get("head") + far);
  });
  // What comes in one message, or faster than the page draws, is drawn once; a page that nobody sees draws nothing until somebody does.
  let act = null;
  const soon = (wanted) => () => {
    if (!Plotly || gone) return;
    if (act === null) requestAnimationFrame(() => {
      const due = act;
      act = null;
      if (!gone) due();
    });
    if (act !== draw) act = wanted;
  };
  const redraw = soon(draw), point = soon(move);
  model.on("change:data", redraw);
  model.on("change:frame", redraw);
  model.on("change:head", point);
  model.on("change:head change:story change:last", tell);
  tell();
  plotly.ready.then(async (loaded) => {
    if (gone) return;
    Plotly = loaded;
    plot.textContent = "";
    await draw();
    const over = ({ points: [first] }) => (pointed = first.data.hovertext?.[first.pointNumber] ?? "", tell());
    plot.on("plotly_hover", over);
    plot.on("plotly_unhover", () => (pointed = "", tell()));
  });
  if (!plotly.there) model.send({ kind: "plotly" });
  return () => {
    gone = true;
    model.off("change:data", redraw);
    model.off("change:frame", redraw);
    model.off("change:head", point);
    model.off("change:head change:story change:last", tell);
    removeEventListener("pointermove", held);
    if (Plotly) Plotly.purge(plot);
  };
}

export default { initialize: hears(initialize), render };
