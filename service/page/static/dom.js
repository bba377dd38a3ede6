// Elements are made of text and of other elements, never of markup: what users typed stays text.

/**
 * Make an element.
 * @param {string} tag
 * @param {Object} attributes a name that begins with "on" is an event; null and false leave one out
 * @param {...(Node|string|number|null|Array)} children null leaves one out
 */
export function h(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return node;
}

/** Put these, and nothing else, into an element. */
export function fill(node, ...children) {
  node.replaceChildren(...children.flat(Infinity).filter((child) => child !== null));
  return node;
}

/** A button that does something, and cannot be pressed again while it is at it. */
export function button(text, action, attributes = {}) {
  const node = h("button", { type: "button", ...attributes }, text);
  node.addEventListener("click", async () => {
    node.disabled = true;
    try {
      await action(node);
    } finally {
      node.disabled = false;
    }
  });
  return node;
}

/** Text for plotly.js, which takes some tags for markup. */
export function plain(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
}
