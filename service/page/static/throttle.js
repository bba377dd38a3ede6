// Looks at a result that grows, at most one at a time and with a pause between two.

/** Least milliseconds between two. */
const PAUSE = 1500;

/** Returns a function that shows what is known so far by `show`, to be called at each change. */
export function throttled(show) {
  let last = 0;
  let busy = false;
  return async () => {
    if (busy || performance.now() - last < PAUSE) return;
    busy = true;
    try {
      await show();
    } catch {
      // The next change or the result is shown instead.
    } finally {
      last = performance.now();
      busy = false;
    }
  };
}
