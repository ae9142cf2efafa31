// What is chosen first and then given: acknowledging and answering an alarm, orders, resources. The buttons stand at one place, whatever
// becomes of the lists below.

import { signal } from "@preact/signals";
import type { Act, Alarm, Cell, OperateButton, Page } from "./model";
import { Acts } from "./operate";
import { t } from "./texts";

/** What is chosen, by the name of its choice. */
const chosen = signal<Record<string, string>>({});

const choose = (name: string, value: string) => (chosen.value = { ...chosen.value, [name]: value });
const choice = (name: string) => chosen.value[name] ?? "";

/** A choice of one thing; what is not there any more is not chosen. */
function Choice({ name, label, of }: { name: string; label: string; of: [value: string, text: string][] }) {
  const value = of.some(([value]) => value === choice(name)) ? choice(name) : "";
  return (
    <label class="choose">
      {label}
      <select value={value} data-choice={name} onChange={(event) => choose(name, (event.target as HTMLSelectElement).value)}>
        <option value="">{t.choose}</option>
        {of.map(([value, text]) => (
          <option value={value} key={value}>
            {text}
          </option>
        ))}
      </select>
    </label>
  );
}

/** A text or a number of the operator. */
function Entry({ name, label, type, max }: { name: string; label: string; type: "text" | "number"; max: number }) {
  return (
    <label class="choose">
      {label}
      <input
        type="text"
        inputMode={type === "number" ? "numeric" : "text"}
        maxLength={max}
        value={choice(name)}
        data-choice={name}
        onInput={(event) => choose(name, (event.target as HTMLInputElement).value)}
      />
    </label>
  );
}

/** A whole number; null where there is none. */
function whole(text: string): number | null {
  return /^\d{1,9}$/.test(text) ? Number(text) : null;
}

/** A button for what is chosen. `missing`: what has to be chosen before. */
function button(key: string, label: string, act: Act | null, missing: string): OperateButton {
  return { key, label, act: act ?? { give_up: {} }, why_not: act === null ? missing : null };
}

const cut = (text: string) => (text.length > 70 ? `${text.slice(0, 69)}…` : text);

export function AlarmForms({ page }: { page: Page }) {
  const alarm: Alarm | undefined = page.alarms.find((of) => String(of.shown) === choice("alarm"));
  // An answer is chosen for one alarm, and for no other after it.
  const answer_to = `answer to ${alarm?.shown ?? ""}`;
  const answer = alarm?.answers.find((of) => of.answer === choice(answer_to));
  const acknowledge = alarm === undefined ? null : { acknowledge: { shown: alarm.shown, note: choice("note") } };
  const answered = alarm?.number == null || answer === undefined ? null : { answer: { alarm: alarm.number, word: answer.answer } };
  return (
    <section class="forms">
      <Choice name="alarm" label={t.alarm} of={page.alarms.map((of) => [String(of.shown), cut(`${of.source}: ${of.text}`)])} />
      <Entry name="note" label={t.note} type="text" max={100} />
      <Acts page={page} of={[button("acknowledge", t.acknowledge, acknowledge, t.choose_alarm)]} />
      {page.is_cell && (
        <>
          <Choice name={answer_to} label={t.answer} of={(alarm?.answers ?? []).map((of) => [of.answer, of.answer])} />
          <p class="value fixed" id="chosen-answer">
            {answer && [answer.meaning, answer.verdict, answer.why].filter(Boolean).join("; ")}
          </p>
          <Acts page={page} of={[button("answer", t.give_answer, answered, t.choose_answer)]} />
        </>
      )}
    </section>
  );
}

export function CellForms({ page, cell }: { page: Page; cell: Cell }) {
  const product = cell.products.find((of) => of === choice("product"));
  const [quantity, due] = [whole(choice("quantity")), whole(choice("due"))];
  const due_s = due === null ? undefined : due * 60;
  const is_due_read = due !== null || choice("due") === "";
  const submitted =
    product === undefined || quantity === null || !is_due_read ? null : { submit: { product, quantity, name: choice("order name"), due_s } };
  const open = cell.orders.filter((of) => !of.is_over);
  const order = open.find((of) => of.name === choice("order"))?.name;
  const resource = cell.resources.find((of) => of === choice("resource"));
  const about = order ?? resource;
  const of_resource = (to: "up" | "down" | "reset") => (resource === undefined ? null : { resource: { resource, to } });
  return (
    <section class="forms">
      <h2>{t.order_new}</h2>
      <Choice name="product" label={t.product} of={cell.products.map((of) => [of, of])} />
      <Entry name="quantity" label={t.quantity} type="number" max={9} />
      <Entry name="order name" label={t.order_name} type="text" max={60} />
      <Entry name="due" label={t.due_minutes} type="number" max={9} />
      <Acts page={page} of={[button("submit", t.submit, submitted, t.choose_product)]} />
      <h2>{t.order_or_resource}</h2>
      <Choice name="order" label={t.order} of={open.map((of) => [of.name, of.name])} />
      <Choice name="resource" label={t.resource} of={cell.resources.map((of) => [of, of])} />
      <Acts page={page} of={[button("why", t.why(about), about === undefined ? null : { why: { about } }, t.choose_order_or_resource)]} />
      <Acts
        page={page}
        of={[
          button("cancel", t.cancel, order === undefined ? null : { cancel: { order } }, t.choose_order),
          button("withdraw", t.withdraw, order === undefined ? null : { withdraw: { order } }, t.choose_order),
        ]}
      />
      <Acts
        page={page}
        of={[
          button("resource down", t.down, of_resource("down"), t.choose_resource),
          button("resource up", t.up, of_resource("up"), t.choose_resource),
          button("resource reset", t.reset_resource, of_resource("reset"), t.choose_resource),
        ]}
      />
    </section>
  );
}
