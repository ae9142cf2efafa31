// Buttons that act while they are held, by pointer or by the space bar.
//
// A hold ends at whatever may mean that nobody holds it any more, and never begins again by itself: each press has a number that is used
// once. The server counts a press as ended too when no beat comes, so that a page that fails releases as well.

import { signal } from "@preact/signals";
import { connection, is_live, on_loss, operate, shown } from "./feed";
import type { Act } from "./model";
import { t } from "./texts";

const BEAT_MS = 100;
/** The server ends a press whose beats are further apart. */
const STALLED_MS = 250;

interface HoldButton {
  key: string;
  act: Act;
  /** Of the button of the next step: the number of that. */
  step?: number;
}

interface Hold {
  key: string;
  number: number;
  connection: number;
  element: HTMLElement;
  /** None of a hold by the space bar. */
  pointer: { id: number; x: number; y: number } | null;
  timer: ReturnType<typeof setInterval>;
  beat_at: number;
}

/** Highest number of a press so far. It is never set back. */
let last = 0;
let hold: Hold | null = null;

/** The key of the button that is held here, and why the last hold has ended by itself. */
export const held = signal<string | null>(null);
export const ended = signal<{ key: string; why: string } | null>(null);

/** Whether the pointer is inside the button, nothing covers it there, and it is still the button that was pressed. */
function is_inside(of: Hold): boolean {
  if (!of.element.isConnected || of.element.dataset.key !== of.key) return false;
  if (of.pointer === null) return document.activeElement === of.element;
  const at = document.elementFromPoint(of.pointer.x, of.pointer.y);
  return at !== null && of.element.contains(at);
}

function beat(): void {
  if (hold === null) return;
  const now = performance.now();
  const page = shown.value?.page;
  const note = page?.control.notes[hold.connection];
  if (now - hold.beat_at > STALLED_MS) end(t.ended_stalled);
  else if (!is_live() || hold.connection !== connection.value) end(t.ended_lost);
  else if (document.hidden || !document.hasFocus()) end(t.ended_away);
  else if (page?.control.holder?.connection !== connection.value) end(t.ended_control);
  else if (note?.press === hold.number) end(note.text);
  else if (!is_inside(hold)) end(t.ended_left);
  else {
    hold.beat_at = now;
    if (!operate({ beat: { number: hold.number } })) end(t.ended_lost);
  }
}

function begin(of: HoldButton, element: HTMLElement, pointer: Hold["pointer"]): void {
  const { key, act, step } = of;
  if (hold !== null) return end(t.ended_second);
  if (!("press" in act)) return;
  last += 1;
  const is_sent = is_live() && operate({ press: { ...act.press, number: last } }, step);
  ended.value = is_sent ? null : { key, why: t.ended_lost };
  if (!is_sent || connection.value === null) return;
  hold = { key, number: last, connection: connection.value, element, pointer, timer: setInterval(beat, BEAT_MS), beat_at: performance.now() };
  held.value = key;
}

/** Ends the hold; why, where it was not let go. */
function end(why: string | null): void {
  if (hold === null) return;
  const { key, number, timer } = hold;
  clearInterval(timer);
  hold = null;
  held.value = null;
  if (why !== null) ended.value = { key, why };
  operate({ release: { number } });
}

/** The handlers of a button that is held. `may`: whether it would do something now. */
export function holds(of: HoldButton, may: boolean, refuse: () => void) {
  return {
    onPointerDown: (event: PointerEvent) => {
      event.preventDefault();
      if (!event.isPrimary || event.button !== 0) return end(t.ended_second);
      const element = event.currentTarget as HTMLElement;
      element.focus();
      if (!may) return refuse();
      begin(of, element, { id: event.pointerId, x: event.clientX, y: event.clientY });
    },
    onKeyDown: (event: KeyboardEvent) => {
      if (event.code !== "Space") {
        if (hold !== null && hold.pointer === null) end(t.ended_second);
        return;
      }
      event.preventDefault();
      if (event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
      if (!may) return refuse();
      begin(of, event.currentTarget as HTMLElement, null);
    },
    onContextMenu: (event: Event) => event.preventDefault(),
    // A click is a release: the hold has ended by then.
    onClick: (event: Event) => event.preventDefault(),
  };
}

/** What ends a hold wherever it happens. */
export function watch_holds(): void {
  const on = (name: string, end_of: (event: PointerEvent) => void) =>
    addEventListener(name, (event) => hold?.pointer && end_of(event as PointerEvent), { capture: true });
  on("pointermove", (event) => {
    const at = hold!.pointer!;
    if (event.pointerId !== at.id) return;
    [at.x, at.y] = [event.clientX, event.clientY];
    // A second mouse button has no event of its own.
    if (event.buttons !== 1) end(event.buttons === 0 ? null : t.ended_second);
    else if (!is_inside(hold!)) end(t.ended_left);
  });
  for (const name of ["pointerup", "pointercancel"]) {
    on(name, (event) => event.pointerId === hold!.pointer!.id && end(name === "pointerup" ? null : t.ended_cancelled));
  }
  // What touches a second time ends the hold, and begins no other one.
  const second = (event: Event) => {
    if (hold === null) return;
    end(t.ended_second);
    event.stopPropagation();
  };
  addEventListener("pointerdown", second, { capture: true });
  // Outside of the window a mouse moves unseen.
  document.documentElement.addEventListener("pointerleave", () => hold?.pointer && end(t.ended_left));
  addEventListener("keyup", (event) => event.code === "Space" && hold !== null && hold.pointer === null && end(null), { capture: true });
  addEventListener("keydown", (event) => hold !== null && hold.pointer !== null && (second(event), event.preventDefault()), { capture: true });
  addEventListener("blur", () => end(t.ended_away));
  addEventListener("pagehide", () => end(t.ended_away));
  document.addEventListener("visibilitychange", () => document.hidden && end(t.ended_away));
  document.addEventListener("focusout", (event) => hold !== null && event.target === hold.element && end(t.ended_left));
  on_loss(() => end(t.ended_lost));
}
