// The page: its head with the alarm banner, one of the pages, and what is shown when frames are lost.

import { signal } from "@preact/signals";
import { render } from "preact";
import { useLayoutEffect } from "preact/hooks";
import { Chart } from "./chart";
import { begin, drawn, lost_for, shown } from "./feed";
import type { Page } from "./model";
import { watch_holds } from "./hold";
import { Control, Operate, has_control } from "./operate";
import { Alarms, Cell, Overview, Waiting } from "./pages";
import { Priority } from "./parts";
import { t } from "./texts";

const names = ["overview", "operate", "chart", "alarms", "cell", "waiting"] as const;
type Name = (typeof names)[number];

const here = (): Name => names.find((name) => `#${name}` === location.hash) ?? "overview";
const at = signal<Name>(here());
addEventListener("hashchange", () => (at.value = here()));

function Banner({ page }: { page: Page }) {
  const first = page.alarms[0];
  if (first === undefined) return <p class="banner none value">{t.alarms_none}</p>;
  return (
    <a class="banner" href="#alarms">
      <Priority of={first.priority} text={first.priority_text} />
      <span class="value what">{`${first.source}: ${first.text}`}</span>
      <span class="value">{t.more_alarms(page.alarms.length)}</span>
    </a>
  );
}

/** Whether this page had control when it was drawn last. */
const had_control = signal(false);
const lost_control = signal(false);

// That control was taken by another page, until this one takes it again, or its notice is closed.
function Taken({ page }: { page: Page }) {
  const has = has_control(page);
  useLayoutEffect(() => {
    if (has) lost_control.value = false;
    else if (had_control.value && page.control.holder !== null) lost_control.value = true;
    had_control.value = has;
  }, [has, page.control.holder?.connection]);
  if (has || !lost_control.value) return null;
  return (
    <p class="taken" role="alert">
      {page.control.holder === null ? t.control_gone : t.control_taken(page.control.holder.name)}{" "}
      <button type="button" onClick={() => (lost_control.value = false)}>
        {t.read}
      </button>
    </p>
  );
}

function Lost() {
  const age = lost_for.value;
  if (age === null) return null;
  const text = shown.value === null ? t.never : t.lost((age / 1000).toFixed(1));
  return (
    <div id="lost" role="alert">
      {text}
    </div>
  );
}

function Body() {
  const now = shown.value;
  useLayoutEffect(() => {
    if (now !== null) drawn(now);
  }, [now]);
  if (now === null) return null;
  const page = now.page;
  const name = at.value === "cell" && !page.is_cell ? "overview" : at.value;
  return (
    <>
      <header>
        <div class="title">
          <h1>{page.title}</h1>
          <p>
            {t.mode}:{" "}
            <strong id="mode" class={page.mode.is_known ? "value" : "value is-unknown"}>
              {page.mode.is_known ? page.mode.word : t.unknown}
            </strong>
          </p>
        </div>
        <nav aria-label={t.pages}>
          {names
            .filter((name) => name !== "cell" || page.is_cell)
            .map((of) => (
              <a href={`#${of}`} aria-current={of === name ? "page" : undefined} key={of}>
                {t[of]}
              </a>
            ))}
        </nav>
        <Banner page={page} />
        <Control page={page} />
        <Taken page={page} />
      </header>
      <main>
        {name === "overview" && <Overview page={page} />}
        {name === "operate" && <Operate page={page} />}
        {name === "chart" && <Chart shown={now} />}
        {name === "alarms" && <Alarms page={page} />}
        {name === "cell" && <Cell page={page} />}
        {name === "waiting" && <Waiting page={page} />}
      </main>
      <footer>{t.no_safety}</footer>
    </>
  );
}

render(
  <>
    <Body />
    <Lost />
  </>,
  document.getElementById("page")!,
);
watch_holds();
begin();
