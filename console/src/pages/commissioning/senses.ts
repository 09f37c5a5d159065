// Inputs of the monitor: sensors, end switches, button posts, temperatures.
import { css, html, nothing, svg, type TemplateResult } from 'lit';
import { customElement } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { flag as flagOf } from '../../hub/dictionary';
import { badText, type Reading, readingOf } from '../../hub/readings';
import type { FlagSet, SubsystemName } from '../../hub/types';
import { t, tt } from '../../i18n';
import { icon } from '../../parts/icons';
import { type Quantity, show } from '../../units';
import { Step } from './base';
import { BUTTONS, type ButtonName, type ButtonState, buttonState, type Fact } from './model';

interface Row {
  id: string;
  name: string;
  value: string;
  /** Flags that mark it as faulty. */
  faults: FlagSet;
  note?: string;
}

const DRIVES = ['Horizontal', 'Vertical', 'Nozzle', 'Deployer'] as const;
const DRIVE_FAULTS = [
  'PositionWayFault',
  'PosEncoderFault',
  'SpeedEncoderFault',
  'SpeedWayFault',
  'MotorBroken',
  'ConnLost',
] as const;

/** A value as text; a bad one is marked as such. */
function judged(quantity: Quantity, subsystem: SubsystemName, of: Reading): string {
  const text = show(quantity, of.value);
  return badText(subsystem, of) ? `(${text}) ${t('operate.bad_value')}` : text;
}

@customElement('lf-step-sensors')
export class StepSensors extends Step {
  override render() {
    const rows = this.rows();
    const left = rows.filter((row) => !this.work[row.id] || this.faults(row).length).length;
    return html`<p>${t('commissioning.sensors.text')}</p>
      <div class="scroll">
        <table>
          <thead>
            <tr>
              <th>${t('commissioning.sensors.what')}</th>
              <th class="num">${t('commissioning.sensors.value')}</th>
              <th>${t('commissioning.sensors.state')}</th>
              <th>${t('commissioning.sensors.plausible')}</th>
            </tr>
          </thead>
          <tbody>
            ${rows.map((row) => this.row(row))}
          </tbody>
        </table>
      </div>
      ${this.done(
        left ? t('commissioning.sensors.why', { n: left }) : this.stale ? t('commissioning.why_stale') : '',
        () =>
          rows.map((row): Fact => ({ key: 'commissioning.fact.sensor', args: { name: row.name, value: row.value } })),
      )}`;
  }

  private row(row: Row) {
    const faults = this.faults(row);
    return html`<tr>
      <td>${row.name}${row.note ? html`<div class="small dim">${row.note}</div>` : nothing}</td>
      <td class="num ${this.stale ? 'stale' : ''}"><b>${row.value}</b></td>
      <td>
        ${
          faults.length
            ? faults.map((name) => this.told('bad', tt(flagOf(row.faults.subsystem, name)?.meaning) || name))
            : this.told('good', t('commissioning.sensors.sound'))
        }
      </td>
      <td>
        <label class="check alone"
          ><input
            type="checkbox"
            aria-label="${t('commissioning.sensors.plausible')}: ${row.name}"
            .checked=${this.work[row.id] === true}
            @change=${(e: Event) => this.keep({ [row.id]: (e.target as HTMLInputElement).checked })}
        /></label>
      </td>
    </tr>`;
  }

  private rows(): Row[] {
    const number = (quantity: Quantity, field: string, subsystem: SubsystemName = 'General') =>
      judged(quantity, subsystem, readingOf(this.of(subsystem), field));
    const range = `${this.value('General', 'MainVoltageMin') ?? '—'} … ${this.value('General', 'MainVoltageMax') ?? '—'}`;
    const rows: Row[] = [
      {
        id: 'voltage',
        name: t('commissioning.sensors.voltage'),
        value: number('voltage', 'main_voltage'),
        faults: { subsystem: 'General', flags: ['BadPower'] },
        note: t('commissioning.sensors.allowed', { range }),
      },
      {
        id: 'pressure',
        name: t('commissioning.sensors.pressure'),
        value: number('pressure', 'pressure'),
        faults: { subsystem: 'General', flags: ['PressureSensorBreak', 'PressureSensorShort'] },
        note: t('commissioning.sensors.pressure_note'),
      },
      {
        id: 'flow',
        name: t('commissioning.sensors.flow'),
        value: number('flow', 'flowrate'),
        faults: { subsystem: 'General', flags: [] },
      },
    ];
    for (const drive of DRIVES.filter((name) => this.exists(name))) {
      const ends = (['Min', 'Max'] as const).map((end) =>
        t(
          this.has(drive, `Absolute${end}LimitReached`)
            ? 'commissioning.sensors.switch_on'
            : 'commissioning.sensors.switch_off',
        ),
      );
      rows.push({
        id: drive,
        name: t(`commissioning.drive.${drive}`),
        value: `${number(drive === 'Nozzle' ? 'nozzle' : 'angle', 'position', drive)} · ${number('current', 'current', drive)}`,
        faults: { subsystem: drive, flags: DRIVE_FAULTS },
        note: t('commissioning.sensors.switches', { min: ends[0]!, max: ends[1]! }),
      });
    }
    return rows;
  }

  private faults(row: Row): string[] {
    const { subsystem, flags } = row.faults;
    return flags.filter((name) => this.has<SubsystemName>(subsystem, name));
  }
}

type Seen = Partial<Record<ButtonName, true>>;
const POSTS = ['Buttons', 'ExtButtons'] as const;

@customElement('lf-step-buttons')
export class StepButtons extends Step {
  static override styles = [
    ...Step.styles,
    css`
      .post {
        display: grid;
        grid-template-columns: repeat(4, minmax(84px, 1fr));
        gap: var(--s2);
      }
      .button {
        display: grid;
        justify-items: center;
        gap: var(--s1);
        padding: var(--s2) var(--s1);
        border: 1px solid var(--line);
        border-radius: var(--radius);
        text-align: center;
        font-size: var(--t-note);
      }
      .button svg.dial {
        width: 56px;
        height: 56px;
      }
      .dial circle {
        fill: var(--surface-2);
        stroke: var(--line-strong);
        stroke-width: 2;
      }
      .button.Pressed {
        border-color: var(--accent);
        background: var(--accent-soft);
      }
      .button.Pressed .dial circle {
        fill: var(--accent);
        stroke: var(--accent);
      }
      .button.Short,
      .button.Open {
        border-color: var(--medium);
        background: var(--medium-soft);
      }
      .dial path {
        fill: none;
        stroke: var(--accent);
        stroke-width: 3;
      }
      .button .state {
        color: var(--dim);
        min-height: 18px;
      }
      .button.Short .state,
      .button.Open .state {
        color: var(--medium);
        font-weight: 650;
      }
      @media (max-width: 560px) {
        .post {
          grid-template-columns: 1fr 1fr;
        }
      }
    `,
  ];

  override willUpdate(): void {
    if (this.stale) return;
    for (const post of POSTS) {
      const flags = this.of(post)?.flags ?? [];
      const seen = this.seen(post);
      const fresh = BUTTONS.filter((button) => !seen[button] && buttonState(flags, button) === 'Pressed');
      if (fresh.length) this.keep({ [post]: { ...seen, ...Object.fromEntries(fresh.map((b) => [b, true])) } });
    }
  }

  override render() {
    const posts = POSTS.filter((post) => this.exists(post));
    const locked = this.has('General', 'LockedOut');
    const open = posts.filter((post) => !this.isDone(post));
    return html`<p>${t('commissioning.buttons.text')}</p>
      ${this.moves(t('commissioning.buttons.moves'))}
      ${
        locked
          ? this.told('good', t('commissioning.buttons.locked'))
          : html`<div class="acts">
            <lf-button icon="lock" @click=${() => commands.lockout(this.monitor).catch(() => {})}
              >${t('commissioning.buttons.lock')}</lf-button
            >
            <span class="dim">${t('commissioning.buttons.lock_text')}</span>
          </div>`
      }
      ${posts.map((post) => this.post(post))}
      ${this.done(open.length ? t('commissioning.buttons.why', { list: open.join(', ') }) : '', () =>
        posts.map(
          (post): Fact => ({
            key: this.work[`${post}None`] ? 'commissioning.fact.no_post' : 'commissioning.fact.post',
            args: { post },
          }),
        ),
      )}`;
  }

  private post(post: (typeof POSTS)[number]) {
    const flags = this.of(post)?.flags ?? [];
    const seen = this.seen(post);
    const none = this.work[`${post}None`] === true;
    const count = BUTTONS.filter((button) => seen[button]).length;
    return html`<div class="box">
      <div class="acts">
        <h3 class="grow">${t(`commissioning.post.${post}`)}</h3>
        <span class="dim">${t('commissioning.buttons.count', { n: count, of: BUTTONS.length })}</span>
      </div>
      <div class="post">${BUTTONS.map((button) => this.button(button, buttonState(flags, button), seen[button] === true))}</div>
      ${this.check(t('commissioning.buttons.none'), none, (on) => this.keep({ [`${post}None`]: on }))}
    </div>`;
  }

  private button(button: ButtonName, state: ButtonState, seen: boolean): TemplateResult {
    return html`<div class="button ${state}">
      <svg class="dial" viewBox="0 0 56 56" aria-hidden="true">
        ${svg`<circle cx="28" cy="28" r="20"></circle>`}${seen ? svg`<path d="M28 3A25 25 0 1 1 27.9 3"></path>` : nothing}
      </svg>
      <b>${t(`commissioning.button.${button}`)}</b>
      <span class="state ${this.stale ? 'stale' : ''}">${t(`commissioning.button_state.${state}`)}</span>
      <span class="state">${seen ? html`${icon('check', 14)} ${t('commissioning.buttons.seen')}` : nothing}</span>
    </div>`;
  }

  private seen(post: string): Seen {
    return (this.work[post] as Seen | undefined) ?? {};
  }

  private isDone(post: string): boolean {
    if (this.work[`${post}None`]) return true;
    const flags = this.of(post)?.flags ?? [];
    const seen = this.seen(post);
    return BUTTONS.every((button) => seen[button] && buttonState(flags, button) === 'Released');
  }
}

const NODES = ['horizontal', 'vertical', 'nozzle', 'deployer', 'housing'] as const;
const NODE_FLAG = {
  horizontal: 'Horizontal',
  vertical: 'Vertical',
  nozzle: 'Nozzle',
  deployer: 'Deployer',
  housing: 'Box',
} as const;

@customElement('lf-step-climatics')
export class StepClimatics extends Step {
  override render() {
    const on = this.value('Climatics', 'HeatOn');
    const off = this.value('Climatics', 'HeatOff');
    const faults =
      NODES.flatMap((node) => this.faults(node)).length + (this.has('Climatics', 'HumiditySensorFault') ? 1 : 0);
    const order = on !== undefined && off !== undefined && off <= on;
    const why = faults
      ? t('commissioning.climatics.why_faults', { n: faults })
      : order
        ? t('commissioning.climatics.order')
        : this.work.plausible
          ? ''
          : t('commissioning.climatics.why');
    return html`<p>${t('commissioning.climatics.text', { on: show('temperature', on), off: show('temperature', off) })}</p>
      ${order ? this.told('bad', t('commissioning.climatics.order')) : nothing}
      <div class="scroll">
        <table>
          <thead>
            <tr>
              <th>${t('commissioning.climatics.node')}</th>
              <th class="num">${t('commissioning.climatics.temperature')}</th>
              <th>${t('commissioning.climatics.heating')}</th>
              <th>${t('commissioning.sensors.state')}</th>
            </tr>
          </thead>
          <tbody>
            ${NODES.map((node) => {
              const bad = this.faults(node);
              const heats = this.has('Climatics', `${NODE_FLAG[node]}Heat`);
              return html`<tr>
                <td>${t(`commissioning.node.${node}`)}</td>
                <td class="num ${this.stale ? 'stale' : ''}"><b>${this.climate('temperature', node)}</b></td>
                <td>${t(heats ? 'commissioning.climatics.on' : 'commissioning.climatics.off')}</td>
                <td>
                  ${
                    bad.length
                      ? bad.map((name) => this.told('bad', tt(flagOf('Climatics', name)?.meaning)))
                      : this.told('good', t('commissioning.sensors.sound'))
                  }
                </td>
              </tr>`;
            })}
            <tr>
              <td>${t('commissioning.climatics.humidity')}</td>
              <td class="num ${this.stale ? 'stale' : ''}"><b>${this.climate('percent', 'humidity')}</b></td>
              <td></td>
              <td>
                ${
                  this.has('Climatics', 'HumiditySensorFault')
                    ? this.told('bad', tt(flagOf('Climatics', 'HumiditySensorFault')?.meaning))
                    : this.told('good', t('commissioning.sensors.sound'))
                }
              </td>
            </tr>
          </tbody>
        </table>
      </div>
      ${this.check(t('commissioning.climatics.plausible'), this.work.plausible === true, (yes) => this.keep({ plausible: yes }))}
      ${this.done(why, () =>
        NODES.map(
          (node): Fact => ({
            key: 'commissioning.fact.sensor',
            args: {
              name: t(`commissioning.node.${node}`),
              value: this.climate('temperature', node),
            },
          }),
        ),
      )}`;
  }

  private climate(quantity: Quantity, field: string): string {
    return judged(quantity, 'Climatics', readingOf(this.of('Climatics'), field));
  }

  private faults(node: (typeof NODES)[number]): string[] {
    const name = NODE_FLAG[node];
    return ([`${name}Fault`, `${name}SensorFault`] as const).filter((flag) => this.has('Climatics', flag));
  }
}
