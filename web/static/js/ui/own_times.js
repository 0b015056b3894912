// Times that the server wrote in UTC, as the viewer's clock shows them; UTC stays in the title.

/** @param {ParentNode} parent */
export function showOwnTimes(parent) {
  const format = new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "medium" });
  for (const element of parent.querySelectorAll("time[datetime]")) {
    const at = new Date(/** @type {HTMLTimeElement} */ (element).dateTime);
    if (!Number.isNaN(at.getTime())) element.textContent = format.format(at);
  }
}
