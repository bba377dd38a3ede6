// Landmarks that are shown, with their corrections, kept in the tab for when one comes back to their match.

const nameOf = (match) => `isomatch-landmarks-${match}`;

export const keepLandmarks = (match, shown) => sessionStorage.setItem(nameOf(match), JSON.stringify(shown));

/** What was kept, or null. */
export const keptLandmarks = (match) => JSON.parse(sessionStorage.getItem(nameOf(match)));
