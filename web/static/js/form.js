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
for (const area of document.querySelectorAll("textarea[data-longest]")) {
  if (area instanceof HTMLTextAreaElement) countDown(area);
}
for (const form of document.querySelectorAll("form[method=post]")) {
  if (form instanceof HTMLFormElement) sendOnce(form);
}
