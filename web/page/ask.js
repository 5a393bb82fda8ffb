// Requests whose answers are small, and files that are sent.

const PATIENCE_MS = 30_000;

export const NO_ANSWER = "the server does not answer. Try again in a moment.";

/** `fetch` that gives up after PATIENCE_MS: a lost peer may never close its connection. */
export const ask = (address, options = {}) =>
  fetch(address, { signal: AbortSignal.timeout(PATIENCE_MS), ...options });

/** An address of this server, for a page of this session. more: further parameters. */
export const addressOf = (path, session, more = {}) =>
  `${path}?${new URLSearchParams({ session, ...more })}`;

export const unreadable = (name) =>
  `${name} cannot be read: it is a folder, or is no longer there. Choose another file.`;

/** Whether the browser can read a file; otherwise a request with it would seem to get no answer. */
export async function isReadable(file) {
  try {
    // Some browsers report a file that is gone as empty, and reading a part of an empty file
    // succeeds.
    await (file.size ? file.slice(0, 1) : file).arrayBuffer();
    return true;
  } catch {
    return false;
  }
}
