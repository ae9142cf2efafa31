// The model of the page, as the crate `linewright-console-view` writes it.

export type StretchKind = "moving" | "undoing" | "halted" | "stopped" | "unknown";

/** Times are ms since the begin of the console, as `now_ms` of a frame. */
export interface Stretch {
  kind: StretchKind;
  from_ms: number;
  to_ms: number | null;
}

export interface Lane {
  operation: string;
  stretches: Stretch[];
}

export interface StationLanes {
  station: string;
  label: string;
  lanes: Lane[];
}

export type Health = "unknown" | "emergency_stop" | "fault" | "left_out" | "not_ready" | "manual" | "ok";

export interface Station {
  name: string;
  label: string;
  health: Health;
  unknown: string | null;
  mode: string | null;
  cycle: number | null;
  operation: string | null;
  moves: boolean | null;
  fault: string | null;
  notes: string[];
  waits_for: string[];
}

export interface Mode {
  is_known: boolean;
  word: string;
  text: string;
  is_enabled: boolean | null;
  waiting_for: string[];
  left_out: string[];
  restarted: string[];
  refusal: string | null;
  refused: string;
  cycle: { number: number; duration_s: number } | null;
}

export interface Answer {
  answer: string;
  meaning: string;
  verdict: string | null;
  why: string | null;
}

export interface Alarm {
  key: string;
  source: string;
  priority: 1 | 2 | 3;
  priority_text: string;
  shown: number;
  state: string;
  acknowledged: { by: string; note: string; age: string } | null;
  text: string;
  age: string;
  number: number | null;
  answers: Answer[];
  lead: string[];
  reset: string[];
  at_order: string[];
  lead_to: string | null;
  lead_because: string;
  bring: [string, string] | null;
}

export interface Cell {
  starting: boolean;
  parts_inside: number;
  parts_left: number;
  orders_open: number;
  parts: { part: number; stage: string; place: string; age: string; order: string | null }[];
  activities: { id: number; name: string; part: number | null; age: string; running: boolean; text: string }[];
  orders: { id: number; name: string; text: string; due: string | null; is_late: boolean; is_over: boolean }[];
  out_of_service: { resource: string; text: string }[];
  products: string[];
  resources: string[];
}

/** What is done at a page, as the server reads it. */
export type Act =
  | { take: { name: string } }
  | { give_up: Record<string, never> }
  | { command: { word: string; station?: string } }
  | { select: { station: string; manual: boolean } }
  | { press: { number: number; station?: string; button: string } }
  | { beat: { number: number } }
  | { release: { number: number } }
  | { acknowledge: { shown: number; note: string } }
  | { answer: { alarm: number; word: string } }
  | { submit: { product: string; quantity: number; name: string; due_s?: number } }
  | { cancel: { order: string } }
  | { withdraw: { order: string } }
  | { why: { about: string } }
  | { resource: { resource: string; to: "up" | "down" | "reset" } };

export interface OperateButton {
  key: string;
  label: string;
  act: Act;
  why_not: string | null;
}

export interface OperatePart {
  commands: OperateButton[];
  hand: OperateButton[];
  resume: OperateButton;
  panels: { station: string; holds: OperateButton[]; selects: OperateButton[]; is_manual: boolean | null }[];
}

export interface Plan {
  begin: string[];
  steps: { text: string; since: string | null; stands: string[] }[];
  end: string[];
  next: number | null;
  button: OperateButton | null;
  step: number;
}

export interface ControlPart {
  holder: { connection: number; name: string; since: string } | null;
  press: { number: number; button: string } | null;
  /** By the number of the connection. */
  notes: Record<string, { key: string; press: number | null; text: string }>;
}

export interface Page {
  operate: OperatePart;
  plan: Plan | null;
  control: ControlPart;
  title: string;
  is_cell: boolean;
  mode: Mode;
  other_descriptions: string[];
  next: string | null;
  stations: Station[];
  lanes: StationLanes[];
  alarms: Alarm[];
  cell: Cell | null;
  cell_unknown: string | null;
}

/** A frame: the whole page, or what has changed since the frame before. */
export interface Frame {
  sequence: number;
  now_ms: number;
  page?: Page;
  changes?: [(string | number)[], unknown][];
}
