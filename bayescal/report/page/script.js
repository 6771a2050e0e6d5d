"use strict";
// Tables can be sorted; without this script they are read as they stand.
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
  const key = (row, i) => {
    const given = row.cells[i].dataset.value;
    return given === undefined ? row.cells[i].textContent.trim() : Number(given);
  };
  const compare = (a, b) =>
    typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
  heads.forEach((head, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const empty = (row) => key(row, i) === "";
      const rows = [...body.rows];
      rows.sort((a, b) =>
        empty(a) - empty(b) || (up ? 1 : -1) * compare(key(a, i), key(b, i)));
      body.append(...rows);
    });
  });
}
for (const button of document.querySelectorAll("button.save")) {
  button.parentElement.hidden = false;
  button.addEventListener("click", () => {
    const text = document.getElementById(button.dataset.from).textContent;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
    link.download = button.dataset.file;
    link.click();
    URL.revokeObjectURL(link.href);
  });
}
// The contents mark the section that is read.
const sections = [...document.querySelectorAll("main > section")], list = document.querySelector("nav ol");
function mark() {
  const end = innerHeight + scrollY >= document.documentElement.scrollHeight - 2;
  const begun = sections.filter((s) => s.getBoundingClientRect().top < innerHeight / 3);
  const read = end ? sections.at(-1) : begun.at(-1) ?? sections[0];
  for (const link of list.querySelectorAll("a")) {
    const here = link.hash === "#" + read.getAttribute("aria-labelledby");
    if (here && !link.hasAttribute("aria-current")) {
      link.setAttribute("aria-current", "true");
      list.scrollLeft = link.offsetLeft - list.offsetLeft - (list.clientWidth - link.clientWidth) / 2;
    } else if (!here) link.removeAttribute("aria-current");
  }
}
addEventListener("scroll", mark, { passive: true });
addEventListener("resize", mark);
mark();
// What is wider than its place fades at the side that has more; it is scrolled by keys, too.
for (const place of [list, ...document.querySelectorAll(".scroll")]) {
  const fade = () => {
    const spare = place.scrollWidth - place.clientWidth, left = place.scrollLeft;
    place.classList.toggle("more-left", left > 1);
    place.classList.toggle("more-right", left < spare - 1);
    if (place !== list) spare > 1 ? (place.tabIndex = 0) : place.removeAttribute("tabindex");
  };
  place.addEventListener("scroll", fade, { passive: true });
  new ResizeObserver(fade).observe(place);
}
// Paper shows what the screen folds away, in browsers whose style sheets can't open it, too.
let folded = [];
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  folded.forEach((details) => { details.open = true; });
});
addEventListener("afterprint", () => folded.forEach((details) => { details.open = false; }));
