// The pages beside the chart.

import { AlarmForms, CellForms } from "./forms";
import type { Alarm, Cell as CellModel, Page, Station } from "./model";
import { Heads, HealthSign, List, Named, Priority } from "./parts";
import { t } from "./texts";

function ModeBlock({ page }: { page: Page }) {
  const { mode } = page;
  return (
    <section class="mode" aria-label={t.mode}>
      <p class={mode.is_known ? "value text" : "value text is-unknown"}>{mode.text}</p>
      {mode.is_enabled === false && <Named head={t.not_all} of={mode.waiting_for} />}
      {mode.refusal && <p class="value">{mode.refusal}</p>}
      <Named head={t.left_out} of={mode.left_out} />
      <Named head={t.restarted} of={mode.restarted} />
      {mode.is_known && !page.is_cell && (
        <p>
          {t.cycle}: <span class="value">{mode.cycle ? `${mode.cycle.duration_s.toFixed(1)} s (${mode.cycle.number})` : t.no_cycle}</span>
        </p>
      )}
      {page.next && (
        <p class="next">
          {t.next}: <span class="value">{page.next}</span> ({t.all_steps})
        </p>
      )}
    </section>
  );
}

function StationCard({ station }: { station: Station }) {
  return (
    <li class={`card ${station.health}`}>
      <h3>
        {station.label} <HealthSign of={station.health} />
      </h3>
      {station.unknown !== null ? (
        <p class="value">{station.unknown}</p>
      ) : (
        <>
          <p class={station.moves ? "value moves" : "value"}>{station.operation}</p>
          <p>
            {t.mode}: <span class="value">{station.mode}</span> · {t.count}: <span class="value">{station.cycle}</span>
          </p>
          {station.notes.map((note, at) => (
            <p class="value" key={at}>
              {note}
            </p>
          ))}
          {station.fault && <p class="value fault-text">{station.fault}</p>}
        </>
      )}
    </li>
  );
}

export function Overview({ page }: { page: Page }) {
  const open = page.cell?.orders.filter((order) => !order.is_over) ?? [];
  return (
    <>
      <ModeBlock page={page} />
      {page.other_descriptions.length > 0 && <List of={page.other_descriptions} />}
      <ul class="cards">
        {page.stations.map((station) => (
          <StationCard station={station} key={station.name} />
        ))}
      </ul>
      {page.is_cell && (
        <section>
          <h2>{t.orders}</h2>
          {page.cell_unknown ? <p class="value is-unknown">{page.cell_unknown}</p> : <Orders orders={open} />}
        </section>
      )}
    </>
  );
}

function Orders({ orders }: { orders: CellModel["orders"] }) {
  if (orders.length === 0) return <p class="value">{t.none}</p>;
  return (
    <ul>
      {orders.map((order) => (
        <li class={order.is_late ? "value late" : "value"} key={order.id}>
          {order.name}: {order.text}
          {order.due && `, ${order.due}`}
        </li>
      ))}
    </ul>
  );
}

function AlarmRow({ alarm }: { alarm: Alarm }) {
  return (
    <tr>
      <td>
        <Priority of={alarm.priority} text={alarm.priority_text} />
      </td>
      <td class="value">
        {alarm.state}
        {alarm.acknowledged && <p>{t.acknowledged(alarm.acknowledged)}</p>}
      </td>
      <td class="value">{alarm.number === null ? alarm.source : `${alarm.source}, ${alarm.number}`}</td>
      <td class="value">{alarm.age}</td>
      <td>
        <p class="value">{alarm.text}</p>
        <Named head={t.at_order} of={alarm.at_order} />
        <Named head={t.reset} of={alarm.reset} />
        <Named head={t.lead} of={alarm.lead} />
        {alarm.lead_to && <p class="value">{`${t.way}: ${alarm.lead_to}${alarm.lead_because && ` (${alarm.lead_because})`}`}</p>}
        {alarm.bring && <p class="value">{t.bring(...alarm.bring)}</p>}
        {alarm.answers.length > 0 && <p>{t.answers}:</p>}
        <ul>
          {alarm.answers.map((of) => (
            <li class="value" key={of.answer}>
              <strong>{of.answer}</strong>
              {[of.meaning, of.verdict, of.why].filter(Boolean).map((text) => `; ${text}`)}
            </li>
          ))}
        </ul>
      </td>
    </tr>
  );
}

export function Alarms({ page }: { page: Page }) {
  return (
    <>
      <AlarmForms page={page} />
      {page.alarms.length === 0 ? (
        <p class="value">{t.alarms_none}</p>
      ) : (
        <table class="list">
          <Heads of={[t.priority, t.state, t.source, t.age, t.text]} />
          <tbody>
            {page.alarms.map((alarm) => (
              <AlarmRow alarm={alarm} key={alarm.key} />
            ))}
          </tbody>
        </table>
      )}
    </>
  );
}

export function Cell({ page }: { page: Page }) {
  const cell = page.cell;
  if (cell === null) return <p class="value is-unknown">{page.cell_unknown}</p>;
  return (
    <>
      <CellForms page={page} cell={cell} />
      <section>
        <h2>{t.in_progress}</h2>
        {cell.activities.length === 0 && <p class="value">{t.none}</p>}
        <List
          of={cell.activities.map(
            (of) => `${of.name}${of.part === null ? "" : `, ${t.part} ${of.part}`}, ${of.age}${of.running ? "" : `, ${t.failed}`}${of.text && `: ${of.text}`}`,
          )}
        />
      </section>
      <section>
        <h2>
          {t.parts}: <span class="value">{t.inside(cell.parts_inside, cell.parts_left)}</span>
          {!cell.starting && <span class="value">; {t.nothing_starts}</span>}
        </h2>
        <table class="list">
          <Heads of={[t.part, t.stage, t.order, t.place, t.age]} />
          <tbody>
            {cell.parts.map((part) => (
              <tr key={part.part}>
                {[part.part, part.stage, part.order ?? "", part.place, part.age].map((text, at) => (
                  <td class="value" key={at}>
                    {text}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </section>
      <section>
        <h2>
          {t.orders}: <span class="value">{t.open(cell.orders_open)}</span>
        </h2>
        <Orders orders={cell.orders} />
      </section>
      <section>
        <h2>{t.out_of_service}</h2>
        {cell.out_of_service.length === 0 ? <p class="value">{t.none}</p> : <List of={cell.out_of_service.map((of) => of.text)} />}
      </section>
    </>
  );
}

export function Waiting({ page }: { page: Page }) {
  return (
    <>
      <ModeBlock page={page} />
      {page.stations.map((station) => (
        <section key={station.name}>
          <h2>
            {station.label} <HealthSign of={station.health} />
          </h2>
          {station.unknown !== null && <p class="value is-unknown">{station.unknown}</p>}
          {station.fault && <p class="value fault-text">{station.fault}</p>}
          {station.unknown === null && station.waits_for.length === 0 && <p class="value">{t.waits_for_nothing}</p>}
          {station.waits_for.length > 0 && <p>{t.waits_for}:</p>}
          <List of={station.waits_for} />
        </section>
      ))}
    </>
  );
}
