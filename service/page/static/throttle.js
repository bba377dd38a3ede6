// Looks at a result that grows, at most one at a time and with a pause between two.

/** Least milliseconds between the end of one and the next. */
const PAUSE = 1500;

/** Returns a function that shows what is known so far by `show`, to be called at each change; the last change is shown, too. */
export function throttled(show) {
  let [busy, again] = [false, false];
  return async () => {
    again = true;
    if (busy) return;
    busy = true;
    while (again) {
      again = false;
      // After a failure the next change or the result is shown instead.
      await show().catch(() => {});
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
    }
    busy = false;
  };
}
