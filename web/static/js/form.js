// Conveniences on pages with forms. Every form works without this script.

/** Puts the reader at the summary of what needs attention. */
function focusSummary() {
  document.getElementById("summary")?.focus();
}

/**
 * Keeps a number and its "prefer not to say" box from contradicting each other.
 * @param {HTMLInputElement} box
 */
function tieDeclineBox(box) {
  const field = document.getElementById(box.dataset["declines"] ?? "");
  if (!(field instanceof HTMLInputElement)) return;
  box.addEventListener("change", () => {
    if (box.checked) field.value = "";
  });
  field.addEventListener("input", () => {
    if (field.value !== "") box.checked = false;
  });
}

/**
 * Puts a slider above a number that goes from one anchor to another. Nothing is chosen until it is
 * moved: its thumb stays hidden, so that the middle does not look like an answer.
 * @param {HTMLElement} field
 */
function addSlider(field) {
  const number = field.querySelector("input");
  const row = field.querySelector(".inline");
  const question = field.querySelector(".question");
  if (!number || !row || !question) return;
  const { low = "", high = "", lowest = "0", highest = "100", step = "1" } = field.dataset;
  const range = document.createElement("input");
  Object.assign(range, { type: "range", min: lowest, max: highest, step });
  range.setAttribute("aria-label", `${question.textContent?.trim()}: ${low} to ${high}`);
  const track = document.createElement("div");
  track.className = "track";
  const ends = [low, high].map((text) => Object.assign(document.createElement("span"), { textContent: text }));
  for (const end of ends) end.setAttribute("aria-hidden", "true");
  track.append(ends[0] ?? "", range, ends[1] ?? "");
  row.before(track);
  const show = (/** @type {boolean} */ chosen) => {
    range.classList.toggle("unset", !chosen);
    if (chosen) range.removeAttribute("aria-valuetext");
    else range.setAttribute("aria-valuetext", "nothing chosen yet");
  };
  const take = () => {
    number.value = range.value;
    show(true);
  };
  for (const kind of ["input", "change", "click"]) range.addEventListener(kind, take);
  const follow = () => {
    const typed = number.value.trim();
    const fits = /^-?\d+$/.test(typed);
    if (fits) range.value = typed;
    show(fits);
  };
  number.addEventListener("input", follow);
  follow();
}

/**
 * Tells how many characters are left, once few are.
 * @param {HTMLTextAreaElement} area
 */
function countDown(area) {
  const longest = Number(area.dataset["longest"]);
  const line = document.createElement("p");
  line.className = "left";
  line.setAttribute("role", "status");
  area.after(line);
  const tell = () => {
    const left = longest - area.value.length;
    if (left >= 0) line.textContent = left <= 200 ? `${left} characters left` : "";
    else line.textContent = `${-left} characters too long`;
  };
  area.addEventListener("input", tell);
  tell();
}

/**
 * Sends a form once, however often its button is pressed; coming back makes it usable again.
 * @param {HTMLFormElement} form
 */
function sendOnce(form) {
  let sent = false;
  form.addEventListener("submit", (event) => {
    if (sent) event.preventDefault();
    sent = true;
  });
  window.addEventListener("pageshow", () => {
    sent = false;
  });
}

focusSummary();
for (const box of document.querySelectorAll("input[data-declines]")) {
  if (box instanceof HTMLInputElement) tieDeclineBox(box);
}
for (const field of document.querySelectorAll("[data-slider]")) {
  if (field instanceof HTMLElement) addSlider(field);
}
for (const area of document.querySelectorAll("textarea[data-longest]")) {
  if (area instanceof HTMLTextAreaElement) countDown(area);
}
for (const form of document.querySelectorAll("form[method=post]")) {
  if (form instanceof HTMLFormElement) sendOnce(form);
}
