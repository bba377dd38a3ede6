// Texts that are kept in the tab until it is closed; where the browser has no room or forbids it, until the page is loaded again.

const memory = new Map();

/** Keep a text; false if it is lost when the page is loaded again. */
export function keep(name, text) {
  drop(name);
  try {
    sessionStorage.setItem(name, text);
    return true;
  } catch {
    memory.set(name, text);
    return false;
  }
}

/** The text that was kept, or null. */
export const kept = (name) => memory.get(name) ?? allowed(() => sessionStorage.getItem(name));

export function drop(name) {
  memory.delete(name);
  allowed(() => sessionStorage.removeItem(name));
}

// If storage is forbidden, reading it is an error, too.
function allowed(read) {
  try {
    return read();
  } catch {
    return null;
  }
}
