"use strict";
const table = document.getElementById("trials");
const rows = [...table.tBodies[0].rows];
const key = (row, at) => {
  const text = row.cells[at].textContent, number = Number(text);
  return text === "" ? null : Number.isNaN(number) ? text : number;
};
const compare = (a, b) => a === b ? 0 : a === null ? 1 : b === null ? -1
  : typeof a === typeof b ? (a < b ? -1 : 1) : typeof a === "number" ? -1 : 1;
for (const button of table.querySelectorAll("th button")) {
  button.disabled = false;
  button.addEventListener("click", () => {
    const head = button.parentElement, at = head.cellIndex, up = head.ariaSort !== "ascending";
    for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
    head.ariaSort = up ? "ascending" : "descending";
    const keyed = rows.map((row) => [key(row, at), row]);
    keyed.sort(([a], [b]) => a === null || b === null ? compare(a, b) : up ? compare(a, b) : compare(b, a));
    table.tBodies[0].append(...keyed.map(([, row]) => row));
  });
}
const wanted = document.getElementById("wanted"), count = document.getElementById("count");
wanted.parentElement.hidden = false;
wanted.addEventListener("input", () => {
  const words = wanted.value.toLowerCase();
  let shown = 0;
  for (const row of rows) shown += !(row.hidden = !row.textContent.toLowerCase().includes(words));
  count.textContent = `${shown} of ${rows.length}`;
});
