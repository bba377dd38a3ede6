// Fields for landmarks: their file, and the coordinate system of the meshes.

import { h } from "./dom.js";
import { choiceField } from "./fields.js";
import { confirmed } from "./question.js";
import { fileArea } from "./uploads.js";

const SYSTEMS = [["LPS", "LPS, as 3D Slicer stores models"], ["RAS", "RAS"]];

export const systemField = () => choiceField("coordinates", "Coordinates of the meshes", SYSTEMS, 0,
  "Positions in files of 3D Slicer name their coordinate system and are converted to that of the meshes.");

/** Whether other landmarks may be carried: if some were corrected, the user is asked. */
export const mayReplace = async (corrected) => !corrected
  || confirmed("Carry other landmarks?", "All corrections would be lost.", "Carry them", "Keep these");

/** @param {string} end whose landmarks these are: "source", "target" or "template" */
export const landmarkFileArea = (end, { name }, about, take) => fileArea(
  { id: `landmarks-${end}`, accept: ".json,.fcsv,.csv" }, [h("strong", {}, `Choose landmarks of the ${end}`), `, ${name}`],
  `MRK.JSON, FCSV or CSV. ${about}`, take);
