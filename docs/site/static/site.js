// A line is not broken within the name of an option, where a browser breaks after its hyphens.
function keepWhole(text) {
    const found = /(?<![\w-])--[\w-]+/.exec(text.data);
    if (!found) return;
    const option = text.splitText(found.index), rest = option.splitText(found[0].length), whole = document.createElement("span");
    whole.className = "whole";
    option.replaceWith(whole);
    whole.append(option);
    keepWhole(rest);
}

// What scrolls can be scrolled by the keyboard, and the two columns beside a page have names.
document.addEventListener("DOMContentLoaded", () => {
    document.querySelectorAll(".highlight-sh pre, code").forEach((box) => {
        const walk = document.createTreeWalker(box, NodeFilter.SHOW_TEXT), texts = [];
        while (walk.nextNode()) texts.push(walk.currentNode);
        texts.forEach(keepWhole);
    });
    document.querySelectorAll("pre, .table-wrapper, .math-wrapper").forEach((box) => { if (box.scrollWidth > box.clientWidth) box.tabIndex = 0; });
    document.querySelector("aside.sidebar-drawer")?.setAttribute("aria-label", "All pages");
    document.querySelector("aside.toc-drawer")?.setAttribute("aria-label", "On this page");
});
