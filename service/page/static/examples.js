// Generated example shapes.

import { button } from "./actions.js";
import { request } from "./api.js";

const PAIR = ["human-standing", "human-walking"];
const ALL = [...PAIR, "cat-standing", "cat-sitting", "horse-standing", "horse-galloping"];

/** @param {function(Array<File>)} take uploads the files */
export function exampleButtons(take) {
  const bring = (names) => async () => take(await Promise.all(names.map(fetched)));
  return [
    button("Choose two generated figures", bring(PAIR)), " ",
    button("Choose six generated shapes", bring(ALL)),
  ];
}

async function fetched(name) {
  const answer = await request(`/page/shapes/${name}.off`);
  return new File([await answer.blob()], `${name}.off`);
}
