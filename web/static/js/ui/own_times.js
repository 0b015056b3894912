// Times that the server wrote in UTC, as the viewer's clock shows them; UTC stays in the title.

/** @param {ParentNode} parent */
export function showOwnTimes(parent) {
  const format = new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "medium" });
  const timeAlone = new Intl.DateTimeFormat(undefined, { timeStyle: "medium" });
  for (const element of parent.querySelectorAll("time[datetime]")) {
    const { dateTime, dataset } = /** @type {HTMLTimeElement} */ (element);
    const at = new Date(dateTime);
    // Where lists are of now, today's date would only fill the line.
    const isToday = "near" in dataset && at.toDateString() === new Date().toDateString();
    if (!Number.isNaN(at.getTime())) element.textContent = (isToday ? timeAlone : format).format(at);
  }
}
