// A job: its progress and its result.

import { button } from "./actions.js";
import { Problem, get, remove } from "./api.js";
import { batchProgress, batchView, stoppedBatchView } from "./batch.js";
import { collectionProgress, collectionView } from "./collection.js";
import { consistentMapsView } from "./consistent_maps.js";
import { h, fill } from "./dom.js";
import { ended, follow } from "./events.js";
import { keepFocus } from "./focus.js";
import { titleOf } from "./lists.js";
import { matchView } from "./match.js";
import { download } from "./download.js";
import { linkButton } from "./share_link.js";
import { problemBox } from "./problem.js";
import { prototypeDetails } from "./prototype.js";
import { registrationView } from "./registration.js";
import { stoppedJob } from "./stopped_job.js";
import { throttled } from "./throttle.js";
import { transferView } from "./transfer.js";
import { kindName, percent, stateName, time } from "./format.js";

const RESULTS = {
  match: matchView, batch: batchView, dissimilarities: collectionView, prototype: learnedView, transfer: transferView,
  registration: registrationView, consistent_maps: consistentMapsView,
};
const PARTIAL = { batch: batchProgress, dissimilarities: collectionProgress };

export async function jobView(place, [id, part], signal) {
  const path = `/v1/jobs/${encodeURIComponent(id)}`;
  const head = h("section", { class: "card" });
  const body = h("div");
  let job = await get(path, signal);
  fill(place, head, body);
  const untitled = `${kindName(job)} – isomatch`;
  document.title = untitled;
  const status = statusOf(job);
  titleOf(job, signal).then((text) => {
    status.title.textContent = text;
    // A result that is shown already has a title of its own.
    if (!signal.aborted && document.title === untitled) document.title = `${text} – isomatch`;
  }).catch(() => {});
  fill(head, status.node);
  if (!ended(job)) {
    const running = new AbortController();
    signal.addEventListener("abort", () => running.abort());
    const partial = job.links.partial ? throttled(() => PARTIAL[job.kind](body, job.links.partial, running.signal)) : () => {};
    await follow(`${path}/events`, (now) => {
      job = now;
      status.show(job);
      if (!ended(job)) partial();
    }, signal, (connected) => {
      status.show(job, connected);
      if (connected) status.answered();
    });
    // A partial result may arrive late.
    running.abort();
    if (signal.aborted) return;
    job = await get(path, signal);
  }
  status.show(job);
  fill(body);
  if (job.state !== "succeeded") {
    await stoppedJob(body, job, job.error, signal);
    if (job.kind === "batch") await stoppedBatchView(body.appendChild(h("div")), job, signal);
  } else if (RESULTS[job.kind]) {
    const result = await orExpired(get(`${path}/result`, signal));
    if (result instanceof Problem) {
      await stoppedJob(body, job, { title: result.title, detail: result.message }, signal);
      return;
    }
    head.className = "finished";
    await RESULTS[job.kind](body, result, job, signal, part);
  }
}

// The result, or the problem that it is no longer kept.
const orExpired = (answer) => answer.catch((error) => {
  if (error.status !== 410) throw error;
  return error;
});

function statusOf(job) {
  const title = h("h2", {}, kindName(job));
  const said = h("p", { class: "status", role: "status" });
  const bar = h("progress", { max: 1, "aria-label": "Progress" });
  const share = h("span", { class: "faint" });
  const cancel = button("Cancel", async () => {
    said.textContent = "Cancelling.";
    fill(box);
    await remove(job.links.self).catch((error) => {
      show(last);
      fill(box, problemBox(error));
      passing = error.passing;
    });
  });
  const box = h("div");
  const all = job.batch === null ? null : h("p", {}, h("a", { href: `#/jobs/${job.batch}` }, "Back to the batch"));
  const node = h("div", {}, title, said, bar, " ", share, " ", cancel, box, all);
  let last = job;
  // Whether the problem that is shown is over when the service answers again.
  let passing = false;
  const show = (now, connected = true) => {
    last = now;
    const over = ended(now);
    keepFocus(node, () => { bar.hidden = cancel.hidden = over; });
    bar.value = now.progress.fraction;
    bar.setAttribute("aria-valuetext", `${now.progress.stage || stateName(now.state)}, ${percent(now.progress.fraction)}`);
    node.dataset.state = now.state;
    share.textContent = now.state === "running" ? percent(now.progress.fraction) : "";
    const text = connected ? sentence(now) : "Connection lost; trying again.";
    // Screen readers announce what is written, even if it is the same.
    if (said.textContent !== text) said.textContent = text;
    if (over) fill(box);
  };
  show(job);
  return { node, title, show, answered: () => passing && fill(box) };
}

function sentence(job) {
  if (job.waiting_for === "worker") return "Waiting: no worker is alive.";
  if (job.state === "queued") {
    if (job.progress.stage === "spectra") return "The spectra of its shapes are computed.";
    if (job.waiting_for === "turn" && job.position === null) return "Waiting for its turn in the batch.";
    return job.position ? `Waiting, with ${job.position} ahead of it.` : "Waiting for a worker.";
  }
  if (job.state === "running") return job.progress.stage + (job.waiting_for ? ", waiting for its turn" : "");
  const asked = `Requested ${time(job.created)}`;
  return `${stateName(job.state)[0].toUpperCase()}${stateName(job.state).slice(1)}. ${asked}.`;
}

function learnedView(place, result, job, signal) {
  return prototypeDetails(place, result.prototype, signal,
    [download(job.links.result, "JSON", `${job.id}.json`), linkButton(job.id)]);
}
