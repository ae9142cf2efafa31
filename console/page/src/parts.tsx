// Signs that several pages have: priority and health, each by shape, number or word as well as by colour.

import type { Health } from "./model";
import { health } from "./texts";

const SHAPES = { 1: "M1 1h18v18H1z", 2: "M10 1 19 19H1z", 3: "M1 1h18L10 19z" };

export function Priority({ of, text }: { of: 1 | 2 | 3; text: string }) {
  return (
    <span class="priority">
      <svg viewBox="0 0 20 20" class={`p${of}`} aria-hidden="true">
        <path d={SHAPES[of]} />
        <text x="10" y={of === 3 ? 11 : 15.5} text-anchor="middle">
          {of}
        </text>
      </svg>
      {text}
    </span>
  );
}

export function HealthSign({ of }: { of: Health }) {
  return <span class={`health ${of} value`}>{health[of]}</span>;
}

export function List({ of }: { of: string[] }) {
  return (
    <ul>
      {of.map((text, at) => (
        <li class="value" key={at}>
          {text}
        </li>
      ))}
    </ul>
  );
}

// The heads of a table's columns.
export function Heads({ of }: { of: string[] }) {
  return (
    <thead>
      <tr>
        {of.map((head) => (
          <th scope="col" key={head}>
            {head}
          </th>
        ))}
      </tr>
    </thead>
  );
}

// Names behind their head, in one line; nothing where there are none.
export function Named({ head, of }: { head: string; of: string[] }) {
  return of.length > 0 ? <p class="value">{`${head}: ${of.join(", ")}`}</p> : null;
}
