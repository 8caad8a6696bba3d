// The list of places that are kept: a table with a button to fly to each and one to take it away, and what saves it.

const BOM = "\ufeff"; // spreadsheets take a file without it for Latin-1

function button(words, title, act) {
  const made = Object.assign(document.createElement("button"), { type: "button", textContent: words, title });
  made.setAttribute("aria-label", title);
  made.addEventListener("click", act);
  return made;
}

function save(text) {
  const address = URL.createObjectURL(new Blob([BOM + text], { type: "text/csv" }));
  Object.assign(document.createElement("a"), { href: address, download: "mechstyle-places.csv" }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

function line(kind, cells) {
  const row = document.createElement("tr");
  for (const cell of cells) {
    const made = document.createElement(kind);
    made.append(cell);
    if (kind === "th") made.scope = "col";
    row.append(made);
  }
  return row;
}

function render({ model, el }) {
  const draw = () => {
    const rows = model.get("rows"), table = document.createElement("table");
    const at = [...el.querySelectorAll("button")].indexOf(document.activeElement);
    el.replaceChildren();
    el.classList.toggle("mechstyle-places", true);
    el.hidden = !rows.length;
    if (!rows.length) {
      if (at >= 0) el.closest(".mechstyle-viewer")?.querySelector("canvas")?.focus(); // else keys would go to the page
      return;
    }
    table.createCaption().append("Places", button("CSV", "Save the places as CSV", () => save(model.get("table"))),
      button("clear", "Take all places away", () => model.send({ kind: "remove" })));
    table.createTHead().append(line("th", [...model.get("head"), ""]));
    const body = table.createTBody();
    rows.forEach((cells, number) => {
      const pin = button(String(number + 1), `Look at place ${number + 1}`, () => model.send({ kind: "fly", number }));
      pin.className = "mechstyle-pin";
      body.append(line("td", [pin, ...cells, button("✕", `Take place ${number + 1} away`, () => model.send({ kind: "remove", number }))]));
    });
    el.append(table);
    if (at >= 0) [...el.querySelectorAll("button")].slice(0, at + 1).at(-1).focus();
  };
  model.on("change:rows", draw);
  draw();
  return () => model.off("change:rows", draw);
}

export default { render };
