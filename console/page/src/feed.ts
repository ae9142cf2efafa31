// Frames from the server, and the loss of them.
//
// A page counts as lost when no frame was drawn for LOST_AFTER_MS, whatever the reason: no server, no network, a script that has failed.
// Clocks of server and browser are never compared, only how far each has gone: a frame that was under way for longer than the one that was
// fastest on its connection, by more than LOST_AFTER_MS, is one of before, and is shown as lost.

import { signal } from "@preact/signals";
import type { Act, Frame, Page } from "./model";

/** Frames come ten times a second; with the period of the look, a loss is shown within 500 ms. */
const LOST_AFTER_MS = 380;
const LOOK_EVERY_MS = 50;
const CONNECT_AGAIN_MS = 400;
/** A connection without frames is opened anew. */
const SILENT_MS = 3000;

export interface Shown {
  page: Page;
  now_ms: number;
  /** How much longer its frame was under way than the fastest one of its connection, in ms. */
  late_ms: number;
}

/** The newest page; null before the first frame. */
export const shown = signal<Shown | null>(null);
/** For how long no frame was drawn, in ms; null while they come. */
export const lost_for = signal<number | null>(null);

/** Number of the present connection; null before its first frame. */
export const connection = signal<number | null>(null);

let socket: WebSocket | null = null;
/** Number that the server has given to the connection, before its first frame. */
let greeted: number | null = null;
let seen_ms = 0;
let lost_listener: () => void = () => {};

/** Called when frames are lost, or the connection. */
export function on_loss(listener: () => void): void {
  lost_listener = listener;
}

/** Whether what is shown is of now, and something may be given. */
export function is_live(): boolean {
  return connection.value !== null && performance.now() - drawn_at <= LOST_AFTER_MS;
}

/** Sends what is done at the page, of the button of the next step with the number of that; false without a connection. It is never kept for
 * later: what waits in the socket is too much. */
export function operate(act: Act, step?: number): boolean {
  if (socket === null || socket.readyState !== WebSocket.OPEN || connection.value === null) return false;
  if (socket.bufferedAmount > 2000) {
    socket.close();
    return false;
  }
  socket.send(JSON.stringify({ seen_ms, act, step }));
  return true;
}

let sequence = 0;
/** Before the first frame nothing is of now. */
let drawn_at = -Infinity;
let received_at = performance.now();
/** Least time of the browser's clock at which a frame came, less the frame's own, on this connection. */
let least_offset = Infinity;

/** A frame was drawn. It is of the time before it was under way. */
export function drawn(of: Shown): void {
  drawn_at = Math.max(drawn_at, performance.now() - of.late_ms);
  seen_ms = of.now_ms;
  look();
}

/** The same value with a change in it; what has not changed stays the same object. */
function changed(value: unknown, path: (string | number)[], at: number, to: unknown): unknown {
  if (at === path.length) return to;
  const step = path[at]!;
  if (Array.isArray(value) && typeof step === "number" && step < value.length) {
    const copy = value.slice();
    copy[step] = changed(value[step], path, at + 1, to);
    return copy;
  }
  if (value !== null && typeof value === "object" && Object.hasOwn(value, step)) {
    const from = value as Record<string | number, unknown>;
    return { ...from, [step]: changed(from[step], path, at + 1, to) };
  }
  throw new Error("a change at a place that the page does not have");
}

function take(frame: Frame): void {
  let page = frame.page;
  if (page === undefined) {
    if (shown.value === null || frame.sequence !== sequence + 1) throw new Error("a frame was missed");
    page = (frame.changes ?? []).reduce<unknown>((page, [path, to]) => changed(page, path, 0, to), shown.value.page) as Page;
  }
  sequence = frame.sequence;
  const offset = performance.now() - frame.now_ms;
  least_offset = Math.min(least_offset, offset);
  const late_ms = offset - least_offset;
  // A connection whose frames are all late counts as silent, so that the next one measures its offset anew.
  if (late_ms < LOST_AFTER_MS) received_at = performance.now();
  shown.value = { page, now_ms: frame.now_ms, late_ms };
  connection.value = greeted;
}

function connect(): void {
  const opened = new WebSocket(`ws://${location.host}/feed`);
  socket = opened;
  received_at = performance.now();
  least_offset = Infinity;
  const silent = setInterval(() => {
    if (performance.now() - received_at > SILENT_MS) opened.close();
  }, CONNECT_AGAIN_MS);
  opened.onmessage = (event) => {
    try {
      const message = JSON.parse(event.data as string) as Frame | { connection: number };
      if ("connection" in message) {
        greeted = message.connection;
        return;
      }
      take(message);
      opened.send(String(sequence));
    } catch (error) {
      // The next connection begins with the whole page.
      console.error(error);
      opened.close();
    }
  };
  opened.onclose = () => {
    connection.value = greeted = null;
    lost_listener();
    clearInterval(silent);
    setTimeout(connect, CONNECT_AGAIN_MS);
  };
}

function look(): void {
  const age = performance.now() - drawn_at;
  const is_lost = age > LOST_AFTER_MS;
  // Outside of what is rendered: it is grey also when rendering fails.
  document.documentElement.classList.toggle("lost", is_lost);
  if (is_lost && lost_for.value === null) lost_listener();
  lost_for.value = is_lost ? Math.floor(age / 100) * 100 : null;
}

export function begin(): void {
  setInterval(look, LOOK_EVERY_MS);
  document.addEventListener("visibilitychange", look);
  connect();
}
