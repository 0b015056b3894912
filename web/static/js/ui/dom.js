// Builds elements without markup strings, as the page's content policy asks.

/**
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Document} document @param {Tag} tag @param {Record<string, string>} attributes
 * @param {...(Node | string)} children @returns {HTMLElementTagNameMap[Tag]}
 */
export function build(document, tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}
