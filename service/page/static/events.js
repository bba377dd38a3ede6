// Changes of a job as server-sent events, read with fetch, as EventSource cannot send an API key.

import { Problem, get, request } from "./api.js";

const ENDED = new Set(["succeeded", "failed", "cancelled"]);
/** Milliseconds until a reconnection. */
const PAUSE = 1000;
/** Milliseconds of silence after which a connection is lost: the service sends something every 15 s. */
const SILENCE = 35_000;

export const ended = (job) => ENDED.has(job.state);

/**
 * Follow a job until it has ended, and reconnect after interruptions.
 * @param {string} path address of the events
 * @param {function(Object)} tell called with the job at each change
 * @param {AbortSignal} signal
 * @param {function(boolean)} connected called with whether the service answers, at each request
 */
export async function follow(path, tell, signal, connected = () => {}) {
  let last = null;
  while (!signal.aborted) {
    try {
      const headers = last === null ? {} : { "Last-Event-ID": last };
      const answer = await request(path, { signal, headers });
      if (answer.status === 204) return;
      connected(true);
      for await (const event of events(answer.body)) {
        last = event.id;
        const job = JSON.parse(event.data);
        tell(job);
        if (ended(job)) return;
      }
    } catch (error) {
      if (signal.aborted) return;
      const again = error instanceof TypeError || (error instanceof Problem && error.passing);
      if (!again) throw error;
      connected(false);
    }
    await new Promise((resolve) => setTimeout(resolve, PAUSE));
  }
}

/**
 * Wait for a job and fetch its result.
 * @throws {Problem} the job did not succeed
 */
export async function resultOf({ links }, signal) {
  await follow(links.events, () => {}, signal);
  const job = await get(links.self, signal);
  if (job.state !== "succeeded") throw new Problem(null, job.error ?? { detail: "The job was cancelled." });
  return get(`${links.self}/result`, signal);
}

async function* events(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  try {
    for (;;) {
      const { done, value } = await soon(reader.read());
      if (done) return;
      text += value;
      const blocks = text.split("\n\n");
      text = blocks.pop();
      for (const block of blocks) {
        const event = fields(block);
        if (event.data !== undefined) yield event;
      }
    }
  } finally {
    reader.cancel().catch(() => {});
  }
}

async function soon(answer) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(Problem.silent(SILENCE)), SILENCE);
  });
  return Promise.race([answer, late]).finally(() => clearTimeout(timer));
}

function fields(block) {
  const lines = block.split("\n").filter((line) => !line.startsWith(":"));
  return Object.fromEntries(lines.map((line) => {
    const colon = line.indexOf(":");
    return [line.slice(0, colon), line.slice(colon + 1).replace(/^ /, "")];
  }));
}
