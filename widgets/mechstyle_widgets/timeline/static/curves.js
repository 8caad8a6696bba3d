// Plotly draws what the kernel holds. Its scripts, 5 MB, are no part of a widget's state, which every page that is loaded anew asks for:
// a page asks for them once, when there is something to draw, and keeps them for all figures to come.

const HERE = Symbol.for("mechstyle.plotly"); // each widget has a module of its own: what is the page's stands with the page
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

function render({ model, el }) {
  const plotly = library();
  let Plotly = null, gone = false;
  const plot = document.createElement("div"), hint = document.createElement("div");
  hint.className = "mechstyle-hint";
  el.classList.add("mechstyle-curves");
  el.replaceChildren(plot, hint);
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
  plotly.ready.then(async (loaded) => {
    if (gone) return;
    Plotly = loaded;
    plot.textContent = "";
    await draw();
    plot.on("plotly_hover", ({ points: [first] }) => (hint.innerHTML = first.data.hovertext?.[first.pointNumber] ?? ""));
    plot.on("plotly_unhover", () => (hint.textContent = ""));
    plot.on("plotly_click", ({ points: [first] }) => model.send({ kind: "click", trace: first.curveNumber, point: first.pointNumber }));
  });
  if (!plotly.there) model.send({ kind: "plotly" });
  return () => {
    gone = true;
    model.off("change:data", redraw);
    model.off("change:frame", redraw);
    model.off("change:head", point);
    if (Plotly) Plotly.purge(plot);
  };
}

export default { initialize: hears(initialize), render };
