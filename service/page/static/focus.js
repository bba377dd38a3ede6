// The keyboard's focus, kept where its element is disabled, hidden, or drawn again.

const REACHED = "a[href], button:not(:disabled), input:not(:disabled, [type=hidden]), select, summary, [tabindex='0']";

const reached = (node) => [...node.querySelectorAll(REACHED)].filter((one) => one.checkVisibility());

const calledLike = (one) => [
  one.tagName, one.id || one.getAttribute("aria-label") || one.textContent, one.type === "radio" ? one.value : "",
].join();

/**
 * Change an element. If what has the focus in it is gone afterwards, the focus goes to what is called the same, else to
 * what is now at its place, else to the area around.
 */
export function keepFocus(node, change) {
  const had = document.activeElement;
  if (had === node || !node.contains(had)) {
    change();
    return;
  }
  const place = reached(node).indexOf(had);
  const name = calledLike(had);
  change();
  if (had.isConnected && had.checkVisibility()) return;
  const now = reached(node);
  const next = now.find((one) => calledLike(one) === name) ?? now[Math.min(Math.max(place, 0), now.length - 1)];
  (next ?? node.closest("[tabindex]"))?.focus();
}

/** Run the action of a button, which does nothing else meanwhile. A disabled button would lose the focus. */
export async function occupied(button, action) {
  if (isOff(button)) return;
  turnOff(button, true);
  try {
    await action();
  } finally {
    turnOff(button, false);
  }
}

/** Mark a button as disabled; its listener has to ask `isOff`. */
export const turnOff = (button, off) => button.setAttribute("aria-disabled", String(off));

export const isOff = (button) => button.getAttribute("aria-disabled") === "true";
