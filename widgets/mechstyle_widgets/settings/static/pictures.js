// Names with small pictures in rows, of which one is chosen: one stop of the Tab key, in which the frame's arrow keys move.

function render({ model, el }) {
  const grid = Object.assign(document.createElement("div"), { className: "mechstyle-pictures" });
  const more = Object.assign(document.createElement("button"), { type: "button", className: "mechstyle-more", title: "More to choose from, or fewer" });
  const names = Object.entries(model.get("names")), addresses = new Map();
  const buttons = new Map(names.map(([name, words]) => {
    const title = name.replaceAll("_", " ");
    const button = Object.assign(document.createElement("button"), { type: "button", title: `${title}: ${words}`, textContent: title });
    button.setAttribute("aria-label", title);
    button.addEventListener("click", () => model.send({ kind: "press", name }));
    return [name, button];
  }));
  grid.setAttribute("role", "group");
  grid.setAttribute("aria-label", `${model.get("kind")}s`);
  grid.append(...buttons.values());
  el.append(grid, more);

  const tell = () => {
    const few = model.get("few"), all = model.get("all"), value = model.get("value"), stop = buttons.has(value) ? value : few[0];
    for (const [name, button] of buttons) {
      button.hidden = !all && !few.includes(name);
      button.tabIndex = name === stop ? 0 : -1;
      button.setAttribute("aria-pressed", String(name === value));
    }
    more.textContent = all ? "fewer" : `all ${names.length} ${model.get("kind")}s`;
    more.setAttribute("aria-expanded", String(all));
    more.hidden = few.length === names.length;
  };
  const hang = () => {
    for (const [name, picture] of Object.entries(model.get("pictures"))) {
      if (addresses.has(name)) continue;
      addresses.set(name, URL.createObjectURL(new Blob([picture], { type: "image/png" })));
      buttons.get(name).style.backgroundImage = `url(${addresses.get(name)})`;
    }
  };
  more.addEventListener("click", () => {
    model.set("all", !model.get("all"));
    model.save_changes();
  });
  model.on("change:value change:all change:few", tell);
  model.on("change:pictures", hang);
  tell();
  hang();
  return () => {
    model.off("change:value change:all change:few", tell);
    model.off("change:pictures", hang);
    addresses.forEach((address) => URL.revokeObjectURL(address));
  };
}

export default { initialize: hears(), render };
