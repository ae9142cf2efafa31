// Lanes of operations. Unknown stretches are hatched, and nothing is drawn as going on beyond the newest frame.

import { signal } from "@preact/signals";
import type { Lane, Stretch, StretchKind } from "./model";
import { lost_for, type Shown } from "./feed";
import { kinds, t } from "./texts";

const WINDOWS_S = [12, 30, 60, 120];
const WIDTH = 1000;
const HEIGHT = 18;
const window_s = signal(30);

function bar(stretch: Stretch, now_ms: number, span_ms: number) {
  const x = (at: number) => WIDTH * (1 - (now_ms - at) / span_ms);
  const from = Math.max(0, x(stretch.from_ms));
  const to = x(stretch.to_ms ?? now_ms);
  if (to <= 0) return null;
  return <rect class={`bar ${stretch.kind}`} x={from} y="2" width={Math.max(to - from, 1)} height={HEIGHT - 4} key={stretch.from_ms} />;
}

function LaneRow({ lane, shown }: { lane: Lane; shown: Shown }) {
  const newest = lane.stretches.at(-1);
  const kind = newest && newest.to_ms === null ? kinds[newest.kind] : t.at_rest;
  return (
    <tr>
      <th scope="row">{lane.operation}</th>
      <td class="value word">{kind}</td>
      <td class="lane">
        <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" aria-hidden="true">
          {lane.stretches.map((stretch) => bar(stretch, shown.now_ms, window_s.value * 1000))}
        </svg>
      </td>
    </tr>
  );
}

function Legend() {
  const all = Object.keys(kinds) as StretchKind[];
  return (
    <p class="legend" aria-label={t.legend}>
      {all.map((kind) => (
        <span key={kind}>
          <svg viewBox="0 0 24 14" aria-hidden="true">
            <rect class={`bar ${kind}`} width="24" height="14" />
          </svg>
          {kinds[kind]}
        </span>
      ))}
    </p>
  );
}

export function Chart({ shown }: { shown: Shown }) {
  return (
    <section>
      <svg class="defs" aria-hidden="true">
        <defs>
          <pattern id="hatch" width="8" height="8" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
            <rect class="hatch-ground" width="8" height="8" />
            <rect class="hatch-line" width="3" height="8" />
          </pattern>
        </defs>
      </svg>
      <fieldset class="choice">
        <legend>{t.window}</legend>
        {WINDOWS_S.map((seconds) => (
          <button key={seconds} aria-pressed={window_s.value === seconds} onClick={() => (window_s.value = seconds)}>
            {t.seconds(seconds)}
          </button>
        ))}
      </fieldset>
      <Legend />
      {shown.page.lanes.map((of) => (
        <table class="lanes" key={of.station}>
          <caption>{of.label}</caption>
          <tbody>
            {of.lanes.map((lane, at) => (
              <LaneRow lane={lane} shown={shown} key={at} />
            ))}
          </tbody>
          <tfoot>
            <tr>
              <td colSpan={2} />
              <td class="axis">
                <span>{t.ago(window_s.value)}</span>
                <span>{lost_for.value === null ? t.now : t.last_frame}</span>
              </td>
            </tr>
          </tfoot>
        </table>
      ))}
    </section>
  );
}
