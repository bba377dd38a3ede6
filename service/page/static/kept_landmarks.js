// Landmarks that are shown, with their corrections, kept in the tab for when one comes back to their match.

const nameOf = (match) => `isomatch-carried-${match}`;

/** Keep landmarks; false if the tab has no room for them. */
export function keepLandmarks(match, shown) {
  try {
    sessionStorage.setItem(nameOf(match), JSON.stringify(shown));
    return true;
  } catch (error) {
    if (error.name !== "QuotaExceededError") throw error;
    return false;
  }
}

export const dropLandmarks = (match) => sessionStorage.removeItem(nameOf(match));

/** What was kept, or null. */
export const keptLandmarks = (match) => JSON.parse(sessionStorage.getItem(nameOf(match)));
