// The list of landmarks beside the shapes: choosing, moving by the keyboard, and resetting.

import { button } from "./actions.js";
import { css, distinct } from "./colors.js";
import { inDoubt } from "./confidence.js";
import { h, table } from "./dom.js";

/** Steps to the right and up, on the screen, of each key. */
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
/** Length of a step with Shift. */
const FINE = 0.1;

/**
 * @param {Array<Object>} landmarks `label`, `lack`, which says why it has no point, and `confidence`, which is null if there is none
 * @param {Corrections} corrections of their positions
 * @param {Selection} selection the landmark that is highlighted
 * @param {function(number, number, number)} step moves a landmark by steps to the right and up
 * @param {AbortSignal} signal aborted when the table is replaced
 */
export function landmarkTable(landmarks, corrections, selection, step, signal) {
  const sure = landmarks.some(({ confidence }) => confidence !== null);
  const rows = landmarks.map((landmark, i) => row(landmark, i, corrections, selection, step, sure));
  const show = () => rows.forEach(({ update }) => update());
  selection.addEventListener("change", show, { signal });
  corrections.addEventListener("change", show);
  show();
  const heads = ["Landmark", ...(sure ? ["Confidence"] : []), "State"];
  return table("Choose a landmark to highlight it on both shapes.", heads, rows.map(({ node }) => node), { class: "pairs" });
}

function row({ label, lack, confidence }, i, corrections, selection, step, sure) {
  const missing = corrections.points[i] === null;
  const choose = chooseButton(label, i, selection, step, missing);
  const said = h("span", {}, lack);
  const reset = button("Reset", () => {
    choose.focus();
    corrections.reset(i);
  }, { class: "small", "aria-label": `Reset ${label}`, hidden: true });
  const node = h("tr", {
    "data-landmark": i,
    onmouseenter: () => selection.hover(missing ? null : i),
    onmouseleave: () => selection.hover(null),
  }, h("th", { scope: "row" }, choose), sure ? h("td", {}, confidenceOf(confidence)) : null, h("td", {}, said, " ", reset));
  const update = () => {
    node.classList.toggle("shown", i === selection.shown);
    choose.setAttribute("aria-pressed", String(i === selection.chosen));
    if (missing) return;
    said.textContent = corrections.moved(i) ? "moved" : "";
    reset.hidden = !corrections.moved(i);
  };
  return { node, update };
}

const confidenceOf = (confidence) => (confidence !== null && inDoubt(Number(confidence))
  ? h("span", { class: "badge doubt" }, `in doubt, ${confidence}`) : confidence ?? "");

function chooseButton(label, i, selection, step, missing) {
  const swatch = h("span", { class: "swatch" });
  swatch.style.background = css(distinct(i));
  return h("button", {
    type: "button", class: "small", "aria-pressed": "false", "aria-describedby": "landmark-keys", disabled: missing,
    onclick: () => selection.choose(i),
    onfocus: () => selection.hover(i),
    onblur: () => selection.hover(null),
    onkeydown: (event) => {
      const towards = KEYS[event.key];
      if (towards === undefined) return;
      event.preventDefault();
      const length = event.shiftKey ? FINE : 1;
      step(i, length * towards[0], length * towards[1]);
    },
  }, swatch, label);
}
