export default {
  'overview.cards': 'Cards and plan',
  'overview.table': 'Table',
  'overview.monitors.one': '{n} monitor',
  'overview.monitors.few': '{n} monitors',
  'overview.monitors.many': '{n} monitors',
  'overview.monitors.other': '{n} monitors',
  'overview.ready_n': '{n} ready',
  'overview.readiness': 'Readiness',
  'overview.state': 'State',
  'overview.control': 'Control',
  'overview.locked': 'Locked out',
  'overview.you': 'You',
};
