// Which pages the site has, for whom and in which order, with their titles in both languages.

/** Languages: folder of their pages, suffix of their files in docs/. */
export const LANGUAGES = [
  { id: 'en', folder: '', suffix: '' },
  { id: 'ru', folder: 'ru/', suffix: '.ru' },
];

/** Marks what a page of the Russian site leads to in English. */
export const IN_ENGLISH = '(по-английски)';

const page = (path, en, ru) => ({ path, title: { en, ru } });

/** The side bar. */
export const GROUPS = [
  {
    title: { en: 'Start', ru: 'Начало' },
    pages: [
      page('tutorial', 'From the box to the first water', 'От распаковки до первой воды'),
      page('install', 'Installation packages', 'Установочные пакеты'),
      page('overview', 'What there is', 'Что есть в lafet'),
    ],
  },
  {
    title: { en: 'Operator', ru: 'Оператор' },
    pages: [
      page('operator', 'Start: operator', 'Начало: оператор'),
      page('console', 'The console', 'Пульт'),
      page('terminal', 'At a terminal', 'В терминале'),
    ],
  },
  {
    title: { en: 'Service engineer', ru: 'Наладчик' },
    pages: [
      page('service-engineer', 'Start: service engineer', 'Начало: наладчик'),
      page('service', 'Commissioning and repair', 'Наладка и ремонт'),
      page('bus', 'Buses, radio, CRC-32C', 'Магистраль, радио, CRC-32C'),
      page('capture', 'Recording and replay', 'Запись обмена'),
      page('conform', 'Conformance test', 'Проверка соответствия'),
      page('faults', 'Faults', 'Неисправности'),
      page('safety-manual', 'Safety manual', 'Руководство по безопасности'),
    ],
  },
  {
    title: { en: 'Integrator', ru: 'Проектировщик системы' },
    pages: [
      page('integrator', 'Start: integrator', 'Начало: проектировщик'),
      page('hub', 'The hub', 'Сервер объекта'),
      page('hub-api', 'The hub’s API', 'API сервера объекта'),
      page('installation', 'Zone controller', 'Контроллер зон'),
      page('modbus', 'Modbus server', 'Сервер Modbus'),
      page('mqtt', 'MQTT', 'MQTT'),
      page('opcua', 'OPC UA', 'OPC UA'),
      page('plugs', 'Clients of others', 'Программы других'),
      page('coverage', 'Coverage of a site', 'Покрытие объекта струями'),
      page('site-test', 'Testing an installation', 'Испытание установки'),
      page('scenarios', 'Scenarios', 'Сценарии'),
      page('json', 'JSON of the commands', 'JSON командной строки'),
      page('send', 'The language of lafet send', 'Язык lafet send'),
      page('python', 'lafet for Python', 'lafet для Python'),
    ],
  },
  {
    title: { en: 'Firmware engineer', ru: 'Разработчик прошивки' },
    pages: [
      page('firmware-engineer', 'Start: firmware engineer', 'Начало: разработчик прошивки'),
      page('firmware', 'The program for a Cortex-M3', 'Программа для Cortex-M3'),
      page('board-stm32f103', 'The board stm32f103', 'Плата stm32f103'),
      page('footprint', 'Flash and RAM', 'Флеш-память и ОЗУ'),
      page('storage', 'Parameters and power cuts', 'Параметры и пропадание питания'),
      page('update', 'Update over the link', 'Обновление по линии связи'),
      page('c', 'lafet for C', 'lafet для C'),
      page('questions', 'Open questions of the document', 'Открытые вопросы документа'),
    ],
  },
  {
    title: { en: 'Developer', ru: 'Разработчик lafet' },
    pages: [
      page('developer', 'Start: developer', 'Начало: разработчик lafet'),
      page('architecture', 'Architecture', 'Архитектура'),
      page('design', 'Why it is built this way', 'Почему построено так'),
      page('contributing', 'Contributing', 'Как вносить изменения'),
      page('release', 'How to release', 'Как выпускать версию'),
      page('playground', 'The playground', 'Песочница'),
      page('client', 'The controlling side', 'Управляющая сторона'),
      page('physics', 'The physics of the simulator', 'Физика имитатора'),
      page('conformance-scenarios', 'Scenarios of the protocol', 'Сценарии протокола'),
      page('sections', 'Sections, code and tests', 'Разделы, код и тесты'),
      page('performance', 'How fast it is', 'Быстродействие'),
    ],
  },
  {
    title: { en: 'Evidence', ru: 'Доказательства' },
    pages: [
      page('evidence', 'Evidence', 'Доказательства'),
      page('evidence-proof', 'Stops, guard and chain', 'Остановы, guard и цепочка'),
      page('model', 'The interlock, model-checked', 'Проверка блокировок на модели'),
      page('evidence-fuzz', 'Fuzzing', 'Фаззинг'),
      page('evidence-long-run', 'The long run', 'Долгий прогон'),
      page('evidence-broken', 'Broken on purpose', 'Намеренно сломанное'),
      page('wrong-monitors', 'Wrong monitors', 'Стволы с внесённой ошибкой'),
    ],
  },
  {
    title: { en: 'Reference', ru: 'Справочник' },
    pages: [
      page('protocol', 'The protocol', 'Протокол'),
      page('parameters', 'Parameters', 'Параметры'),
      page('cli/index', 'Commands', 'Команды'),
      page('api/index', 'HTTP API', 'HTTP API'),
      page('api/structures', 'Structures of the API', 'Структуры API'),
      page('json-schema', 'Schema of --json', 'Схема --json'),
    ],
  },
];

/** The start pages, in the order of the groups, for the first page and the navigation bar. */
export const READERS = ['operator', 'service-engineer', 'integrator', 'firmware-engineer', 'developer'];
