// Requests to the service. Problem documents (RFC 9457) are thrown as a Problem.

import { askForKey, authorization } from "./api_key.js";

/** Milliseconds until a file that is still being validated is requested again. */
const AGAIN = 500;
/** Milliseconds between questions whether a worker is ready, while the answer to an upload waits for its validation. */
const ASK = 1500;
/** Milliseconds until the answer to a request must begin: the service itself waits up to 30 s for its store. */
const PATIENCE = 40_000;
/** The same for files, which may have to be made first. */
export const PATIENCE_FOR_FILES = 90_000;
/** Statuses of a service that is away or busy for a while, or of a proxy before it. */
const PASSING = new Set([0, 429, 502, 503, 504]);

/** A problem document of the service. Its status is 0 if the service cannot be reached, null if no request failed. */
export class Problem extends Error {
  constructor(status, document = {}) {
    // The page shows the errors themselves.
    super(document.detail?.replace(/; `errors` says [a-z ]+\.$/, ".") ?? document.title ?? `The service answered ${status}.`);
    this.status = status;
    this.title = document.title ?? "Something went wrong";
    this.errors = document.errors ?? [];
  }

  /** Whether the same request may succeed a little later. */
  get passing() {
    return PASSING.has(this.status);
  }

  static away() {
    return new Problem(0, {
      title: "No answer",
      detail: "The service does not answer. Is it running, and is the network up?",
    });
  }

  static silent(patience) {
    return new Problem(0, {
      title: "No answer",
      detail: `The service has not answered for ${Math.round(patience / 1000)} s. Is the network up?`,
    });
  }

  static read(status, text) {
    try {
      return new Problem(status, JSON.parse(text));
    } catch {
      return new Problem(status);
    }
  }
}

/**
 * Send a request with the API key, if there is one; if one is missing, ask the user for it.
 * @param {Object} options those of fetch, and `patience`, the milliseconds until its answer must begin
 */
export async function request(path, { signal = null, patience = PATIENCE, ...options } = {}) {
  for (;;) {
    const late = new AbortController();
    const timer = setTimeout(() => late.abort(Problem.silent(patience)), patience);
    let answer;
    try {
      answer = await fetch(path, {
        ...options,
        signal: AbortSignal.any([late.signal, ...(signal ? [signal] : [])]),
        headers: { ...authorization(), ...options.headers },
      });
    } catch (error) {
      throw error instanceof Problem || error.name === "AbortError" ? error : Problem.away();
    } finally {
      clearTimeout(timer);
    }
    if (answer.ok) return answer;
    const problem = Problem.read(answer.status, await answer.text());
    if (answer.status !== 401 || !(await askForKey(problem.message))) throw problem;
  }
}

export const get = async (path, signal) => (await request(path, { signal })).json();

/** The answer of a request, or null if what it asks for does not exist or has expired. */
export async function orNull(answer) {
  try {
    return await answer;
  } catch (error) {
    if (error instanceof Problem && [404, 410].includes(error.status)) return null;
    throw error;
  }
}

export const remove = (path) => request(path, { method: "DELETE" });

/** Idempotency keys of requests whose answer is unknown, by address and body: repeated, they make no second job. */
const unanswered = new Map();

export async function post(path, body) {
  const text = JSON.stringify(body);
  const name = `${path} ${text}`;
  if (!unanswered.has(name)) unanswered.set(name, newKey());
  try {
    const answer = await request(path, {
      method: "POST",
      headers: { "Content-Type": "application/json", "Idempotency-Key": unanswered.get(name) },
      body: text,
    });
    const job = await answer.json();
    unanswered.delete(name);
    return job;
  } catch (error) {
    if (error instanceof Problem && !error.passing) unanswered.delete(name);
    throw error;
  }
}

// crypto.randomUUID exists on secure addresses alone.
const newKey = () => [...crypto.getRandomValues(new Uint32Array(4))].join("-");

/**
 * Upload a file.
 * @param {string} path of the collection that takes it
 * @param {File} file
 * @param {function(number, Object?)} progress called with the fraction that was sent, then with the job that validates it
 * @param {AbortSignal} signal
 * @returns {Promise<Object>} its record
 */
export async function upload(path, file, progress, signal) {
  for (;;) {
    signal?.throwIfAborted();
    const { status, text, location } = await send(path, file, progress, signal);
    if (status === 200 || status === 201) return JSON.parse(text);
    if (status === 202) {
      progress(1, JSON.parse(text));
      return validated(location, progress, signal);
    }
    const problem = status === 0 ? Problem.away() : Problem.read(status, text);
    if (status !== 401 || !(await askForKey(problem.message))) throw problem;
  }
}

// XMLHttpRequest, as fetch reports no progress of a body.
function send(path, file, progress, signal) {
  return new Promise((resolve, reject) => {
    const exchange = new XMLHttpRequest();
    const form = new FormData();
    form.append("file", file, file.name);
    exchange.upload.onprogress = (event) => progress(event.loaded / event.total);
    let asking = null;
    exchange.upload.onload = () => {
      asking = setInterval(async () => {
        const ready = await workerIsReady();
        if (exchange.readyState !== XMLHttpRequest.DONE) progress(1, ready ? undefined : { waiting_for: "worker" });
      }, ASK);
    };
    exchange.onloadend = () => {
      clearInterval(asking);
      resolve({
        status: exchange.status,
        text: exchange.responseText,
        location: exchange.getResponseHeader("Location"),
      });
    };
    exchange.onabort = () => reject(new DOMException("aborted", "AbortError"));
    signal?.addEventListener("abort", () => exchange.abort());
    exchange.open("POST", path);
    for (const [name, value] of Object.entries(authorization())) {
      exchange.setRequestHeader(name, value);
    }
    exchange.send(form);
  });
}

const workerIsReady = () => fetch("/health/ready").then(({ status }) => status !== 503, () => true);

/**
 * Record of a shape, once it is validated.
 * @param {function()} waiting called while it is not
 */
export const shapeRecord = (id, signal, waiting = () => {}) => validated(`/v1/shapes/${encodeURIComponent(id)}`, waiting, signal);

async function validated(location, progress, signal) {
  for (;;) {
    const answer = await request(location, { signal });
    const found = await answer.json();
    if (answer.status !== 202) return found;
    progress(1, found);
    await new Promise((resolve) => setTimeout(resolve, AGAIN));
  }
}
