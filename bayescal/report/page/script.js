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
