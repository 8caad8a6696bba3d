// What scrolls can be scrolled by the keyboard, and the two columns beside a page have names.
document.addEventListener("DOMContentLoaded", () => {
    document.querySelectorAll("pre, .table-wrapper").forEach((box) => { if (box.scrollWidth > box.clientWidth) box.tabIndex = 0; });
    document.querySelector("aside.sidebar-drawer")?.setAttribute("aria-label", "All pages");
    document.querySelector("aside.toc-drawer")?.setAttribute("aria-label", "On this page");
});
