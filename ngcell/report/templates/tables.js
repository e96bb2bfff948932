"use strict";

/** Sort the rows of a table by a column, and the other way round the next time. */
function sortTable(button) {
  const head = button.closest("th"), table = head.closest("table"), body = table.tBodies[0];
  const column = [...head.parentNode.children].indexOf(head);
  const ascending = head.getAttribute("aria-sort") !== "ascending";
  for (const other of head.parentNode.children) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", ascending ? "ascending" : "descending");
  const key = row => {
    const cell = row.cells[column];
    const number = cell.dataset.value === undefined ? NaN : parseFloat(cell.dataset.value);
    return Number.isFinite(number) ? number : cell.dataset.value === undefined ? cell.textContent : null;
  };
  const rows = [...body.rows].map(row => [key(row), row]);
  rows.sort(([a], [b]) => {
    if (a === null || b === null) return (a === null) - (b === null);  // what has no number stands last
    const order = typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
    return ascending ? order : -order;
  });
  body.append(...rows.map(([, row]) => row));
}

/** Show the rows of one level only, or of all. */
function filterTable(choice) {
  const table = document.getElementById(choice.dataset.table);
  for (const row of table.tBodies[0].rows) row.hidden = choice.value !== "" && row.dataset.level !== choice.value;
}

for (const button of document.querySelectorAll("th button")) button.addEventListener("click", () => sortTable(button));
for (const choice of document.querySelectorAll("select[data-table]")) {
  choice.addEventListener("change", () => filterTable(choice));
  filterTable(choice);
}
