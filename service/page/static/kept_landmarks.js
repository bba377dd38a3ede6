// Landmarks that are shown, with their corrections, kept in the tab for when one comes back to their match.

import { drop, keep, kept } from "./tab_storage.js";

const nameOf = (match) => `isomatch-carried-${match}`;

/** Keep landmarks; false if the tab has no room for them. */
export const keepLandmarks = (match, shown) => keep(nameOf(match), JSON.stringify(shown));

export const dropLandmarks = (match) => drop(nameOf(match));

/** The landmarks that were kept, or null. */
export const keptLandmarks = (match) => JSON.parse(kept(nameOf(match)));
