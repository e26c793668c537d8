const powers = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const written = (_, power) => "e" + [...power].map(one => one === "⁻" ? "-" : powers.indexOf(one)).join("");
const number = text => parseFloat(text.replace("−", "-").replace(/ × 10([⁻⁰¹²³⁴-⁹]+)/, written));
for (const head of document.querySelectorAll(".grid th")) {
  const sort = () => {
    const body = head.closest("table").tBodies[0], column = head.cellIndex;
    const down = head.ariaSort === "ascending";
    for (const other of head.parentNode.cells) other.ariaSort = null;
    head.ariaSort = down ? "descending" : "ascending";
    const cell = row => row.cells[column].textContent.trim();
    const compare = (a, b) => {
      const x = number(cell(a)), y = number(cell(b));
      return isNaN(x) || isNaN(y) ? isNaN(x) - isNaN(y) || cell(a).localeCompare(cell(b)) : x - y;
    };
    body.append(...[...body.rows].sort((a, b) => down ? compare(b, a) : compare(a, b)));
  };
  head.tabIndex = 0;
  head.addEventListener("click", sort);
  head.addEventListener("keydown", event => { if (event.key === "Enter") sort(); });
}
