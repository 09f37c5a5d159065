export default {
  'overview.cards': 'Карточки и план',
  'overview.table': 'Таблица',
  'overview.monitors.one': '{n} ствол',
  'overview.monitors.few': '{n} ствола',
  'overview.monitors.many': '{n} стволов',
  'overview.monitors.other': '{n} ствола',
  'overview.ready_n': 'готовы: {n}',
  'overview.readiness': 'Готовность',
  'overview.state': 'Состояние',
  'overview.control': 'Управление',
  'overview.locked': 'Блокировка',
  'overview.you': 'Вы',
};
