// A few names with small pictures, of which one is chosen, and a sheet with all of them in groups, which a search narrows: choosing one,
// Escape or a click elsewhere closes it. The pictures are one stop of the Tab key, in which the frame's arrow keys move.

function render({ model, el }) {
  const part = (tag, className, more = {}) => Object.assign(document.createElement(tag), { className, ...more });
  const say = model.get("words"), names = Object.entries(model.get("names")), found = model.get("found_by"), addresses = new Map();
  const few = part("div", "mechstyle-pictures"), more = part("button", "mechstyle-more", { type: "button", textContent: say.all });
  const sheet = part("div", "mechstyle-sheet", { hidden: true }), search = part("input", "mechstyle-search", { type: "search", placeholder: say.search });
  const nothing = part("div", "mechstyle-none", { textContent: say.none, hidden: true });
  const own = new Map(), buttons = new Map(), groups = [];

  for (const [name, { title, tip }] of names) {
    for (const known of [own, buttons]) {
      const button = part("button", "", { type: "button", title: tip, textContent: title });
      button.setAttribute("aria-label", title);
      button.addEventListener("click", () => press(name));
      known.set(name, button);
    }
  }
  few.setAttribute("role", "group");
  few.setAttribute("aria-label", say.few);
  few.append(...own.values());
  sheet.setAttribute("role", "dialog");
  sheet.setAttribute("aria-label", say.all);
  search.setAttribute("aria-label", say.search);
  more.setAttribute("aria-haspopup", "dialog");
  sheet.append(search, nothing);
  for (const [title, members] of Object.entries(model.get("groups"))) {
    const box = part("div", "mechstyle-pictures");
    box.setAttribute("role", "group");
    box.setAttribute("aria-label", title);
    box.append(...members.map((name) => buttons.get(name)));
    const group = { head: part("h4", "mechstyle-kind", { textContent: title }), box, members };
    groups.push(group);
    sheet.append(group.head, box);
  }
  el.classList.add("mechstyle-picker");
  el.append(few, more, sheet);

  function press(name) {
    model.send({ kind: "press", name });
    open(false);
  }

  function open(all) {
    model.set("all", all);
    model.save_changes();
  }

  const narrow = () => {
    const wanted = search.value.trim().toLowerCase();
    for (const { head, box, members } of groups) {
      for (const name of members) buttons.get(name).hidden = !found[name].includes(wanted);
      head.hidden = box.hidden = members.every((name) => buttons.get(name).hidden);
    }
    nothing.hidden = groups.some(({ box }) => !box.hidden);
    stop();
  };
  const stop = () => { // one stop of the Tab key in each group of buttons
    const value = model.get("value");
    for (const [box, known] of [[few, own], ...groups.map(({ box }) => [box, buttons])]) {
      const seen = [...known].filter(([, button]) => button.parentElement === box && !button.hidden);
      const at = seen.some(([name]) => name === value) ? value : seen[0]?.[0];
      for (const [name, button] of seen) button.tabIndex = name === at ? 0 : -1;
    }
  };
  const tell = () => {
    const shown = model.get("few"), value = model.get("value");
    for (const [name, button] of own) {
      button.hidden = !shown.includes(name);
      button.style.order = shown.indexOf(name);
      for (const one of [button, buttons.get(name)]) one.setAttribute("aria-pressed", String(name === value));
    }
    more.hidden = shown.length === names.length;
    stop();
  };
  const unfold = () => {
    const all = model.get("all"), was = !sheet.hidden;
    sheet.hidden = !all;
    sheet.popover = all ? "manual" : null; // over all that would cut it off
    if (all) {
      sheet.showPopover();
      const { left, top } = few.getBoundingClientRect(), free = innerWidth - sheet.offsetWidth - 8;
      const high = Math.max(8, Math.min(top, innerHeight - 420));
      Object.assign(sheet.style, { left: `${Math.max(8, Math.min(left, free))}px`, top: `${high}px`, maxHeight: `${innerHeight - high - 8}px` });
    }
    more.setAttribute("aria-expanded", String(all));
    if (all && !was) {
      search.value = "";
      narrow();
      search.focus({ preventScroll: true });
    } else if (!all && was && sheet.contains(document.activeElement)) more.focus({ preventScroll: true });
  };
  const hang = () => {
    for (const [name, picture] of Object.entries(model.get("pictures"))) {
      if (addresses.has(name)) continue;
      addresses.set(name, URL.createObjectURL(new Blob([picture], { type: "image/png" })));
      for (const known of [own, buttons]) known.get(name).style.backgroundImage = `url(${addresses.get(name)})`;
    }
  };
  const outside = ({ target }) => { if (!sheet.hidden && !el.contains(target)) open(false); };
  const escape = (event) => {
    if (event.key !== "Escape" || sheet.hidden) return;
    event.stopPropagation();
    open(false);
    more.focus({ preventScroll: true });
  };
  more.addEventListener("click", () => open(!model.get("all")));
  search.addEventListener("input", narrow);
  search.addEventListener("keydown", (event) => { // Enter takes the first that is left
    const first = event.key === "Enter" && groups.flatMap(({ members }) => members).find((name) => !buttons.get(name).hidden);
    if (first) press(first);
  });
  el.addEventListener("keydown", escape);
  document.addEventListener("pointerdown", outside);
  model.on("change:value change:few", tell);
  model.on("change:all", unfold);
  model.on("change:pictures", hang);
  tell();
  narrow();
  unfold();
  hang();
  return () => {
    document.removeEventListener("pointerdown", outside);
    model.off("change:value change:few", tell);
    model.off("change:all", unfold);
    model.off("change:pictures", hang);
    addresses.forEach((address) => URL.revokeObjectURL(address));
  };
}

export default { initialize: hears(), render };
