// Times that the server wrote in UTC, as the viewer's clock shows them; UTC stays in the title.

/** Swedish writes 2026-11-27 19:35:25: short, sorted by eye, and read alike everywhere. */
const ISO_LIKE = "sv-SE";

/** @param {ParentNode} parent */
export function showOwnTimes(parent) {
  const format = new Intl.DateTimeFormat(ISO_LIKE, { dateStyle: "short", timeStyle: "medium" });
  const timeAlone = new Intl.DateTimeFormat(ISO_LIKE, { timeStyle: "medium" });
  for (const element of parent.querySelectorAll("time[datetime]")) {
    const { dateTime, dataset } = /** @type {HTMLTimeElement} */ (element);
    const at = new Date(dateTime);
    // Where lists are of now, today's date would only fill the line.
    const isToday = "near" in dataset && at.toDateString() === new Date().toDateString();
    if (!Number.isNaN(at.getTime())) element.textContent = (isToday ? timeAlone : format).format(at);
  }
}
