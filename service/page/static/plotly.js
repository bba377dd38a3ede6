// plotly.js, loaded on first use.

let loading = null;

export function plotly() {
  loading ??= new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = "/page/plotly.min.js";
    script.onload = () => resolve(window.Plotly);
    script.onerror = () => {
      loading = null;
      reject(new Error("plotly.js, which draws shapes and heat maps, cannot be loaded; reload the page."));
    };
    document.head.append(script);
  });
  return loading;
}

/** A colour of the style sheet. */
export const colorOf = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

export const NO_WEBGL = "This browser does not support WebGL, which is needed to draw shapes.";

let drawable = null;

/** Whether the browser supports WebGL; asked once, as too many contexts would end those of drawings. */
export function canDraw() {
  const canvas = document.createElement("canvas");
  return (drawable ??= (canvas.getContext("webgl2") ?? canvas.getContext("webgl")) !== null);
}

/** Hide what plotly.js has drawn in an element from screen readers, which are told of the element itself. */
export function hideParts(node) {
  const tester = document.getElementById("js-plotly-tester");
  for (const part of [...node.children, tester]) part?.setAttribute("aria-hidden", "true");
}
