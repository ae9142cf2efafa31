// Control and commands. Whether something may be given is decided by the console and by the coordinator; the page shows why not.

import { signal } from "@preact/signals";
import { connection, lost_for, operate } from "./feed";
import { ended, held, holds } from "./hold";
import type { Act, OperateButton, Page } from "./model";
import { HealthSign, List } from "./parts";
import { command_labels, t } from "./texts";

/** The button whose refusal was asked for by a click. */
const asked = signal<{ key: string; why: string } | null>(null);
const name = signal("");

export function has_control(page: Page): boolean {
  return page.control.holder !== null && page.control.holder.connection === connection.value;
}

const is_stop = (act: Act) => "command" in act && act.command.word === "estop";

/** Why a button would do nothing now. The stop is given whatever the page shows. */
function why_not(page: Page, button: OperateButton): string | null {
  if (is_stop(button.act)) return button.why_not;
  if (lost_for.value !== null) return t.not_live;
  // It changes nothing.
  if ("why" in button.act) return button.why_not;
  return has_control(page) ? button.why_not : t.no_control;
}

/** How the coordinator names the command of a button where it refuses it; null of what stations decide. */
function refused_as({ act, label }: OperateButton): string | null {
  if ("command" in act) return [act.command.word, act.command.station].filter(Boolean).join(" ");
  if ("press" in act && act.press.station === undefined) return label === "resume" ? "resume" : "buttons";
  return null;
}

/** What stands at a button: why it did nothing, or why it was released. */
function remark(page: Page, button: OperateButton): string | null {
  const note = page.control.notes[connection.value ?? 0];
  if (ended.value?.key === button.key) return ended.value.why;
  if (note?.key === button.key) return note.text;
  const word = refused_as(button);
  if (word !== null && word === page.mode.refused) return page.mode.refusal;
  if (asked.value?.key === button.key && asked.value.why === why_not(page, button)) return asked.value.why;
  return null;
}

/** A button for an act, with what is to be known of it; of the next step with the number of that. */
function ActButton({ page, button, step }: { page: Page; button: OperateButton; step?: number }) {
  const why = why_not(page, button);
  const refuse = () => (asked.value = why === null ? null : { key: button.key, why });
  const is_hold = "press" in button.act;
  const handlers = is_hold
    ? holds({ key: button.key, act: button.act, step }, why === null, refuse)
    : {
        onClick: () => {
          refuse();
          ended.value = null;
          if (why === null) operate(button.act, step);
        },
      };
  const label = "command" in button.act && button.act.command.station === undefined ? (command_labels[button.label] ?? button.label) : button.label;
  const is_held = held.value === button.key;
  return (
    <button
      type="button"
      class={`${is_hold ? "hold" : ""} ${is_stop(button.act) ? "stop" : ""} ${is_held ? "is-held" : ""}`}
      aria-disabled={why !== null}
      aria-pressed={is_hold ? is_held : undefined}
      data-key={button.key}
      {...handlers}
    >
      {label}
      {is_hold && <small>{is_held ? t.is_held : t.hold_it}</small>}
    </button>
  );
}

/** Buttons with what is to be known of the one that did nothing. Its room is there without a text as well: no button moves under a finger. */
export function Acts({ page, of, step }: { page: Page; of: OperateButton[]; step?: number }) {
  const remarked = of.map((button) => [button.label, remark(page, button)] as const).find(([, text]) => text !== null);
  return (
    <>
      <div class="acts">
        {of.map((button) => (
          <ActButton page={page} button={button} step={step} key={step === undefined ? `${button.key} ${button.label}` : "next step"} />
        ))}
      </div>
      <p class="remark" role="status">
        {remarked && `${remarked[0]}: ${remarked[1]}`}
      </p>
    </>
  );
}

/** Who has control; on every page. */
export function Control({ page }: { page: Page }) {
  const { holder, press, notes } = page.control;
  const is_own = has_control(page);
  const note = notes[connection.value ?? 0];
  const refused = note?.key === "control" ? note.text : null;
  return (
    <div class={is_own ? "control own" : "control"} id="control">
      <span class="value">
        {holder === null ? t.control_none : is_own ? t.control_own(holder.since) : t.control_other(holder.name, holder.since)}
        {press !== null && ` · ${t.pressed(press.button)}`}
      </span>
      {!is_own && (
        <input
          aria-label={t.your_name}
          placeholder={t.your_name}
          maxLength={40}
          value={name.value}
          onInput={(event) => (name.value = (event.target as HTMLInputElement).value)}
        />
      )}
      <button type="button" data-key="control" onClick={() => operate(is_own ? { give_up: {} } : { take: { name: name.value } })}>
        {is_own ? t.give_up : holder === null ? t.take : t.take_over}
      </button>
      {refused !== null && (
        <span class="remark" role="status">
          {refused}
        </span>
      )}
    </div>
  );
}

/** The way back to auto. The button of its next step stands at one place, whatever the step, and so does all that is below. */
function Plan({ page }: { page: Page }) {
  const { plan } = page;
  return (
    <section class="plan">
      <h2>{t.plan}</h2>
      <div class="next-step">
        {plan?.button ? <Acts page={page} of={[plan.button]} step={plan.step} /> : <p>{t.no_next}</p>}
      </div>
      {plan !== null && (
        <div class="steps" tabIndex={0}>
          <List of={plan.begin} />
          <ol>
            {plan.steps.map((step, at) => (
              <li key={at} class={at === plan.next ? "value next" : "value"} aria-current={at === plan.next ? "step" : undefined}>
                {step.text}
                {step.since !== null && <p>{t.since(step.since)}</p>}
                <List of={step.stands.map(t.stands)} />
              </li>
            ))}
          </ol>
          <List of={plan.end} />
        </div>
      )}
    </section>
  );
}

export function Operate({ page }: { page: Page }) {
  const { commands, hand, resume, panels } = page.operate;
  return (
    <>
      <p class={page.mode.is_known ? "value text fixed" : "value text fixed is-unknown"}>{page.mode.text}</p>
      <Acts page={page} of={commands} />
      <Plan page={page} />
      <section>
        <h2>{t.console_buttons}</h2>
        <Acts page={page} of={[...hand, resume]} />
      </section>
      {panels.map((panel, at) => {
        const station = page.stations[at];
        return (
          <section key={panel.station}>
            <h2>
              {panel.station} {station && <HealthSign of={station.health} />}
            </h2>
            <Acts page={page} of={[...panel.holds, ...panel.selects]} />
            <div class="fixed">
              {station && <p class={station.moves ? "value moves" : "value"}>{station.unknown ?? station.operation}</p>}
              {station?.fault && <p class="value fault-text">{station.fault}</p>}
              <p class="value">{panel.is_manual === null ? t.selector_unknown : t.selector(panel.is_manual)}</p>
              {station && station.waits_for.length > 0 && (
                <>
                  <p>{t.waits_for}:</p>
                  <List of={station.waits_for} />
                </>
              )}
            </div>
          </section>
        );
      })}
    </>
  );
}
