// A word that has its place in the glossary explains itself, where the mouse rests on it and where the focus is.

const HESITATION = 600; // a mouse that passes by asks for nothing [ms]

function termAt(target, terms) {
  const own = target.closest("button, label, .widget-label, .lm-TabBar-tab"), box = target.closest(".jupyter-widgets:not(.widget-box, .widget-tab)");
  for (const words of [own?.textContent, box?.querySelector("label, .widget-label")?.textContent, target.selectedOptions?.[0]?.text]) {
    const term = Object.hasOwn(terms, key(words)) && terms[key(words)];
    if (term) return { term, at: own ?? box };
  }
}

const key = (words = "") => words.toLowerCase().split(/[:[]/)[0].trim();

// Explain the words of a root from now on; what it returns ends that.
function explain(root, terms) {
  const tip = Object.assign(document.createElement("div"), { className: "mechstyle-tip", id: `mechstyle-tip-${crypto.randomUUID?.() ?? Math.random()}`, hidden: true });
  tip.setAttribute("role", "tooltip");
  root.append(tip);
  let timer = 0, from = null, quiet = [], pressed = null; // of what was pressed nothing is said until the mouse has left it

  const close = () => {
    clearTimeout(timer);
    from?.removeAttribute("aria-describedby");
    for (const [one, title] of quiet) one.title = title;
    tip.hidden = true;
    [from, quiet] = [null, []];
  };
  const open = (target) => {
    const found = target.isConnected && termAt(target, terms);
    if (!found) return;
    const { term: [word, sentence, picture], at } = found, box = at.getBoundingClientRect(), frame = root.getBoundingClientRect();
    quiet = [at.closest("[title]"), ...at.querySelectorAll("[title]")].filter(Boolean).map((one) => [one, one.title]);
    for (const [one] of quiet) one.removeAttribute("title"); // or the browser says it as well
    tip.innerHTML = `<b>${word}</b>${picture}<span></span>`;
    tip.lastChild.textContent = sentence;
    tip.hidden = false;
    tip.style.left = `${Math.max(0, Math.min(box.left - frame.left + root.scrollLeft, root.clientWidth - tip.offsetWidth - 4))}px`;
    tip.style.top = `${box.bottom - frame.top + root.scrollTop}px`;
    from = target;
    target.setAttribute("aria-describedby", tip.id);
  };
  const ask = (event) => {
    if (tip.contains(event.target)) return;
    close();
    if (pressed?.contains(event.target)) return;
    pressed = null;
    timer = setTimeout(open, HESITATION, event.target);
  };
  const press = ({ target }) => {
    close();
    pressed = target.closest("button, label, .jupyter-widgets") ?? target;
  };
  const leave = (event) => { if (!tip.contains(event.relatedTarget)) close(); };
  const acts = {
    pointerover: ask, pointerout: leave, pointerdown: press, focusout: close,
    focusin: (event) => { if (event.target.matches(":focus-visible")) ask(event); },
    keydown: (event) => { if (event.key === "Escape" && !tip.hidden) { close(); event.stopImmediatePropagation(); } },
  };
  for (const [kind, act] of Object.entries(acts)) root.addEventListener(kind, act);
  return () => {
    close();
    tip.remove();
    for (const [kind, act] of Object.entries(acts)) root.removeEventListener(kind, act);
  };
}

