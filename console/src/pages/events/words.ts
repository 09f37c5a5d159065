// Texts of entries of the audit log. They are made from the typed act; an entry without one, or of a later version of
// the hub, is shown as its own text.
import type { Act, Both, JogEnding, Role, SimAct } from '../../hub/api';
import { dictionaryNow, flag } from '../../hub/dictionary';
import { badText, readingOf } from '../../hub/readings';
import type { AuditEntry, SubsystemStatus } from '../../hub/types';
import { age, type Key, lang, num, t, tt } from '../../i18n';
import { requestWords, subsystemName } from '../../shell/request';
import { measured, show } from '../../units';
import { titleOf } from '../alarms/names';
import type { Simulation } from '../training/model';
import { actOf } from './model';
import { orderWords, zoneWords } from './zones';

const SMALL_STEP_MS = 100_000;

/** Names of scenarios and faults of the simulation. */
let simulation: Pick<Simulation, 'scenarios' | 'faults'> = { scenarios: [], faults: [] };

export function learnSimulation(known: Pick<Simulation, 'scenarios' | 'faults'>): void {
  simulation = known;
}

function known(key: string): string | null {
  const text = t(key as Key);
  return text === key ? null : text;
}

function roleName(role: Role): string {
  return t(`role.${role}`);
}

/** Names that no user can have: what the hub does by itself, and its zones. */
const OWN: Readonly<Record<string, Key>> = { hub: 'events.hub', zones: 'nav.zones' };

/** Whether entries of this user are the hub's own. */
export function isOwn(user: string): boolean {
  return Object.hasOwn(OWN, user);
}

export function userWords(user: string): string {
  return isOwn(user) ? t(OWN[user]!) : user;
}

export function wordsOf(entry: AuditEntry): string {
  const act = actOf(entry);
  return act ? actWords(act, entry.what) : entry.what;
}

/** Every kind that the hub writes: the type comes from the hub's own description. */
function actWords(act: Act, what: string): string {
  switch (act.type) {
    case 'request':
      return requestWords(what);
    case 'jog': {
      const toward = known(`events.toward_${act.drive}_${act.toward}`) ?? act.toward;
      return t('events.jog', { drive: subsystemName(act.drive), toward });
    }
    case 'authority':
      return known(`events.authority_${act.action}`) ?? what;
    case 'login':
      return t('events.login');
    case 'logout':
      return t('events.logout');
    case 'set_up':
      return t('events.set_up', { user: act.user });
    case 'change_own_password':
      return t('events.own_password');
    case 'add_user':
      return t('events.add_user', { user: act.user, role: roleName(act.role) });
    case 'change_user':
      return changeWords(act);
    case 'remove_user':
      return t('events.remove_user', { user: act.user });
    case 'add_token':
      return t('events.add_token', { user: act.name, role: roleName(act.role) });
    case 'remove_token':
      return t('events.remove_token', { n: act.id });
    case 'end_session':
      return t('events.end_session');
    case 'acknowledge':
    case 'unshelve':
      return `${t(`events.alarm_${act.type}`)}: ${titleOf(act.alarm)}`;
    case 'shelve':
      return `${t('events.alarm_shelve', { n: num(act.minutes) })}: ${titleOf(act.alarm)}`;
    case 'export_audit':
      return t('events.exported');
    case 'start_recording':
    case 'remove_recording':
    case 'upload_recording':
      return t(`events.${act.type}`, { name: act.recording });
    case 'store_image':
    case 'remove_image':
      return t(`events.${act.type}`, { version: act.version, board: act.board });
    case 'start_update':
      return t('events.start_update', { version: act.version, monitors: act.monitors.join(', ') });
    case 'stop_update':
      return t('events.stop_update');
    case 'update_monitor':
      return because(versionsOf(act), act.text);
    case 'end_update':
      return because(t('events.end_update', { n: num(act.done), all: num(act.monitors) }), act.text);
    case 'sim_scenario': {
      const title = simulation.scenarios.find(({ id }) => id === act.scenario)?.title;
      return t('events.sim_scenario', { name: tt(title) || act.scenario });
    }
    case 'sim':
      return simWords(act.act);
    case 'zone':
      return zoneWords(act.entry);
    case 'zone_order':
      return orderWords(act.order);
    case 'end':
      return t('events.end');
    case 'clock_step':
      return t(act.by_ms < 0 ? 'events.clock_back' : 'events.clock_forward', { by: stepText(Math.abs(act.by_ms)) });
    case 'state_lost': {
      const aside = act.fault === 'malformed' && act.aside ? ` (${act.aside})` : '';
      return `${t(`events.file_${act.file}`)}: ${t(`events.fault_${act.fault}`)}${aside}`;
    }
    case 'chain_broken':
      return t('events.chain_broken', { n: num(act.n) });
    case 'entries_lost':
      return t('events.entries_lost', { n: num(act.entries) });
    default:
      return act satisfies never;
  }
}

function changeWords({ user, role, password }: Extract<Act, { type: 'change_user' }>): string {
  const parts = [
    role ? t('events.change_role', { role: roleName(role) }) : '',
    password ? t('events.change_password') : '',
  ];
  return `${t('events.change_user', { user })}: ${parts.filter(Boolean).join(', ')}`;
}

/** What became of the software of a monitor. */
function versionsOf({ version, from, to }: Extract<Act, { type: 'update_monitor' }>): string {
  if (to == null) return t('events.update_failed', { version });
  if (from === to) return t('events.update_same', { version: to });
  return from == null ? t('events.update_confirmed', { version: to }) : t('events.update_done', { from, to });
}

/** With the reason, or with what is left to be done. */
function because(words: string, text: Both | null | undefined): string {
  return text ? `${words}. ${tt(text)}` : words;
}

function simWords(act: SimAct): string {
  if ('automatic' in act) return t(act.automatic ? 'events.sim_automatic' : 'events.sim_by_hand');
  if ('pause' in act) return t(act.pause ? 'events.sim_pause' : 'events.sim_on');
  if ('speed' in act) return t('events.sim_speed', { speed: num(act.speed, act.speed % 1 ? 1 : 0) });
  if ('fault' in act) {
    const { monitor, fault, on } = act.fault;
    const name = tt(simulation.faults.find((one) => one.name === fault)?.text) || fault;
    return t(on ? 'events.sim_fault' : 'events.sim_fault_ends', {
      monitor,
      fault: fault === 'all' ? t('events.sim_all') : name,
    });
  }
  if ('fire' in act) {
    const [east = 0, north = 0] = act.fire.at.map((value) => Math.round(value));
    const { unit } = measured('length', 0);
    const at = [east, north].map((value) => measured('length', value).value).join('; ');
    return t('events.sim_fire', { at, unit });
  }
  if ('ignite' in act) return t('events.sim_ignite', { name: act.ignite });
  if ('link' in act)
    return t(act.link.up ? 'events.sim_link_up' : 'events.sim_link_lost', { monitor: act.link.monitor });
  return act satisfies never;
}

/** How a motion by hand ended: why, where. */
export function endingWords(entry: AuditEntry): string {
  const act = actOf(entry);
  if (act?.type !== 'jog' || !act.end) return '';
  const at = (position: number) => show(act.drive === 'Nozzle' ? 'nozzle' : 'angle', position);
  return endWords(act.end, at);
}

function endWords(end: JogEnding, at: (position: number) => string): string {
  switch (end.how) {
    case 'stopped':
      return `${known(`events.end_${end.reason}`) ?? end.reason}, ${at(end.position)}`;
    case 'standing':
    case 'still_moving':
      return at(end.position);
    case 'taken_over':
      return subsystemName(end.by);
    case 'refused':
    case 'unknown':
      return tt(end.text);
    case 'replaced':
      return '';
    default:
      return end satisfies never;
  }
}

/** Meaning of Ok, Denied … */
export function outcomeWords(outcome: string): string {
  return known(`events.outcome_${outcome.replaceAll(' ', '_')}`) ?? outcome;
}

export function outcomeMeaning(outcome: string): string {
  const status = dictionaryNow()?.statuses.find((s) => s.name === outcome);
  return status && !status.success ? tt(status.meaning) : '';
}

/** The state of a subsystem in a line: position, flags; `brief`: without flags that the position implies. */
export function stateWords(name: string, state: SubsystemStatus, brief = false): string {
  const parts: string[] = [];
  const value = (quantity: Parameters<typeof show>[0], field: 'position' | 'pressure' | 'flowrate') => {
    const of = readingOf(state, field);
    if (of.value === null) return;
    const text = show(quantity, of.value);
    const bad = badText(name, of);
    parts.push(bad ? t('events.bad_value', { value: text, why: bad }) : text);
  };
  value(name === 'Nozzle' ? 'nozzle' : 'angle', 'position');
  value('pressure', 'pressure');
  value('flow', 'flowrate');
  const flags = brief ? state.flags.filter((one) => !one.includes('Limit')) : state.flags;
  for (const one of flags) parts.push(flag(name, one)?.meaning[lang()].replace(/\.$/, '') ?? one);
  return parts.join(', ') || '—';
}

/** Ten minutes, or thirty days: a small step to a tenth of a second. */
function stepText(ms: number): string {
  return ms < SMALL_STEP_MS ? t('admin.s', { n: num(ms / 1000, 1) }) : age(ms);
}
