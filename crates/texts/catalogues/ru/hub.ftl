## What the hub says: errors, alarms, events, its configuration.

# Roles.
role-observer = наблюдатель
role-operator = оператор
role-engineer = инженер
role-administrator = администратор

# Names of users.
name-length = Имя — 1…64 знака, без пробелов по краям и двух подряд внутри.
name-characters = В имени допустимы буквы, цифры, пробелы и . - _ @ + '.
name-letters = В имени должна быть буква или цифра.
name-alphabets = Слово в имени — из букв одного алфавита: латинские и кириллические похожи.
name-of-hub = Это имя занято самим сервером объекта.
name-alike = Это имя похоже на «{ $other }», которое уже есть.

# Passwords.
password-short = Пароль — не короче 10 знаков.
password-guessed = Такой пароль легко подобрать. Возьмите три-четыре не связанных слова или пароль длиннее; без рядов клавиш, повторов, дат и имён.

# Alarms: the condition, its cause, what follows, what to do.
alarm-link-down = Нет соединения со стволом.
alarm-link-down-cause = Отказ кабеля, сети или преобразователя интерфейса либо ствол обесточен.
alarm-link-down-consequence = Отсюда им нельзя управлять и нельзя его остановить; начатое продолжается само.
alarm-link-down-remedy = Используйте кнопочный пост у ствола; проверьте питание, кабель и адрес.
alarm-unreadable = На линии ствола идут байты, которые на { $baud } бод не складываются в кадры.
alarm-unreadable-cause = Скорость устройств на линии не та, что в baud= конфигурации, либо помехи, обрыв провода, нет согласования.
alarm-withheld-consequence = Ствол не опрашивается, и управлять им нельзя, чтобы не мешать другим; Stop, Close и Lockout on отправляются.
alarm-unreadable-remedy = Завершите сервер объекта и найдите скорость командой `lafet doctor URL`; исправьте baud= в конфигурации, проверьте её командой `lafet serve --check` и запустите сервер. Если это помехи, которые не устранить, с insist=1 в URL запросы всё же отправляются.
alarm-controller = На линии ствола передаёт контроллер магистрали, а сервер объекта не входит в число его пультов.
alarm-controller-cause = Линия принадлежит магистрали, устройства которой передают в свою очередь, предоставленную контроллером, либо контроллер подключён по ошибке.
alarm-controller-remedy = Впишите в URL конфигурации role=active и свой src= (129…254), проверьте её командой `lafet serve --check` и перезапустите сервер; или отсоедините контроллер. С insist=1 запросы отправляются рядом с контроллером, который никому не предоставляет доступ.
monitor-silent = Ствол не отвечает.
alarm-stale-cause = Линия есть, но ствол выключен, перезапускается, имеет другой адрес или скорость либо ответы теряются.
alarm-keep-out = Вода попадает в запретный сектор «{ $name }»; сервер объекта перекрывает её.
alarm-keep-out-cause = Ствол повернули туда с места или другой программой.
alarm-keep-out-consequence = Пока затвор не закрыт, вода попадает на то, что сектор защищает.
alarm-keep-out-remedy = Предупредите людей. Отведите ствол при закрытых затворах. Если вода ещё идёт, закройте ручную задвижку.
alarm-unheld = При отказе сервера объекта или связи ручное перемещение может продолжаться дольше 0,5 с.
alarm-unheld-cause = У ствола нет параметра MoveHold: привод остановится примерно через 2 с. Либо линия медленная (ответ через 180 мс и более): привод остановится примерно через три таких времени.
alarm-unheld-consequence = Тот, кто стоит у ствола при ручном перемещении, дольше находится в опасности.
alarm-unheld-remedy = При ручном перемещении держите аппаратный аварийный останов под рукой. Установите прошивку с MoveHold или ускорьте линию; где нельзя ни того ни другого, отложите тревогу.
alarm-recordings = Папкой записей нельзя пользоваться.
alarm-recordings-cause = Её нельзя создать, прочесть или писать в неё: путь неверен или не подключён, права, диск полон или только для чтения; точнее — в журнале программы.
alarm-recordings-consequence = При тревогах и по запросу ничего не записывается; остальное работает.
alarm-recordings-remedy = Исправьте folder в [recording] или права, подключите или освободите диск; попытка повторяется раз в минуту и при каждой записи.
alarm-disk = Диск с данными сервера объекта почти заполнен.
alarm-disk-low-cause = Свободно меньше 500 МБ либо меньше 5 % диска и 5 ГБ; что занимает место, показывает страница «Пользователи», вкладка «Сервер».
alarm-disk-consequence = Когда он заполнится, журнал аудита, события и история будут ждать в памяти и пропадут при завершении программы.
alarm-disk-remedy = Освободите место: удалите записи обмена или то, что оставили другие программы, либо сократите сроки хранения в hub.toml.
alarm-certificate = Сертификат сервера объекта истекает в ближайшие 30 дней или уже истёк.
alarm-certificate-cause = Его не заменили вовремя.
alarm-certificate-consequence = Когда он истечёт, браузеры и программы откажутся подключаться к серверу объекта.
alarm-certificate-remedy = Положите новый сертификат с ключом на место файлов из hub.toml; сервер прочтёт их сам.
certificates-read = Сертификаты прочитаны заново: они изменились.
certificates-useless = Сертификаты изменились и не годятся, действуют прежние: { $what }
alarm-audit = Журнал аудита не сохраняется.
alarm-disk-cause = Диск заполнен, доступен только для чтения или отказал.
alarm-audit-consequence = Команды исполняются; записи ждут в памяти и пропадут при завершении программы.
alarm-audit-remedy = Освободите место или исправьте диск; записи сохранятся сами.
alarm-chain = Журнал аудита изменён.
alarm-chain-cause = Файл audit.db правили, либо его повредил диск.
alarm-chain-consequence = На управление не влияет. Записи, начиная с указанной в журнале событий, ничего не доказывают.
alarm-chain-remedy = Сохраните копию папки для расследования; затем восстановите audit.db либо уберите его и запустите с --accept-lost audit.
alarm-state = Потеряны файлы состояния.
alarm-state-cause = Файлы в папке сервера объекта удалены, заменены или укорочены, или диск не даёт их прочитать; какие — в журнале событий.
alarm-state-consequence = На управление не влияет. Того, что в них было, больше нет.
alarm-state-remedy = Выясните причину, восстановите копию, если она есть; затем квитируйте тревогу.
alarm-logins = Идёт подбор паролей.
alarm-logins-cause = За последние минуты много неудачных входов; пользователи и адреса — в журнале аудита.
alarm-logins-consequence = Вход с нового места ждёт. С мест, откуда пользователь уже входил, — не ждёт.
alarm-logins-remedy = Найдите адреса в журнале аудита и отключите их от сети сервера объекта.
alarm-revocations = Завершённые сеансы и удаления пользователей не сохранены.
alarm-revocations-consequence = Они действуют. Если сервер объекта перезапустится раньше, чем диск их примет, они могут пропасть.
alarm-revocations-remedy = Освободите место или исправьте диск до перезапуска сервера объекта.
alarm-zones = Режимы, отключения и запреты зон не сохраняются.
alarm-zones-consequence = Они действуют. Если сервер объекта перезапустится раньше, чем диск их примет, отключённые и заблокированные зоны вернутся к записанному прежде.
alarm-zones-remedy = Освободите место или исправьте диск до перезапуска сервера объекта; затем повторите то, что зоны потеряли.
alarm-history = История не сохраняется.
alarm-history-cause = Диск заполнен или неисправен; либо PostgreSQL, если он используется, не отвечает или не принимает сервер объекта.
alarm-history-consequence = На управление не влияет. Значений за это время не будет; для PostgreSQL они ждут в памяти, пока их не слишком много.
alarm-history-remedy = Освободите место либо исправьте сервер или url раздела [history].
alarm-events = Журнал событий не сохраняется.
alarm-events-cause = Диск заполнен, неисправен или не отвечает либо повреждён events.db; точнее — в журнале программы.
alarm-events-consequence = На управление не влияет. В памяти ждут 10 000 событий; после перезапуска их не будет, а тревоги могут быть такими, какими сохранены последний раз.
alarm-events-remedy = Освободите место или замените диск. Если повреждён events.db, остановите сервер объекта, перенесите файл в другую папку и запустите сервер снова.

# Alarms of the zones.
alarm-trouble = { $subject }: { $trouble }.
alarm-detector-cause = У извещателя или его шлюза нет питания или связи, он неисправен либо загрязнено окно.
alarm-detector-consequence = Голоса у него нет: пуск в его зонах задержится или останется только тревога.
alarm-detector-remedy = Наблюдайте за его участком; проверьте извещатель, шлюз и связь.
alarm-idle-cause = Ствол отклоняет команду, не движется затвор или привод либо заблокирован пост.
alarm-idle-consequence = Вместо него используется другой ствол зоны, если он есть.
alarm-idle-remedy = Возьмите управление и откройте вручную либо используйте пост у ствола.
alarm-not-closed-cause = Затвор не закрывается, отказал его датчик либо ствол не отвечает.
alarm-not-closed-consequence = Вода может идти.
alarm-not-closed-remedy = Посмотрите, идёт ли вода; перекройте её у ствола.
alarm-no-monitor-cause = Все её стволы не отвечают, неисправны, заблокированы, закрыты или под управлением людей.
alarm-no-monitor-consequence = В зону с пуском вода не идёт.
alarm-no-monitor-remedy = Тушите другими средствами; верните управление стволом или сбросьте его.
alarm-few-jets-cause = Стволы зоны не отвечают, неисправны, заблокированы, закрыты или под управлением людей, а замены им нет.
alarm-few-jets-consequence = В зону идёт меньше воды, чем задумано.
alarm-few-jets-remedy = Верните управление стволом или сбросьте его; помогите другими средствами.
alarm-path-cause = Обрыв провода, нет питания устройства либо линия не отвечает.
alarm-path-consequence = У входа действует последнее состояние: нажатие не будет замечено. Выход может не исполнить команду.
alarm-path-remedy = Используйте пульт или посты стволов, клапаны и насосы — вручную; проверьте провод и устройство.
alarm-output-cause = Линия или устройство не принимает команду либо не движется клапан, реле или контактор.
alarm-output-consequence = Он может оставаться в прежнем состоянии. Команда повторяется каждую секунду.
alarm-output-remedy = Приведите его в действие вручную на месте; проверьте устройство и концевой выключатель.
alarm-pump-cause = Насос не работает, в нём нет воды либо отказало реле давления или его линия.
alarm-pump-consequence = Вместо него включается резервный, если он есть. Струи могут быть короче.
alarm-pump-remedy = Включите насос вручную на месте; проверьте питание, всасывание и реле давления.
alarm-contact-cause = Кнопка ещё нажата либо контакт сварился.
alarm-contact-consequence = Пост пуска не даёт пуска, кнопка задержки не держит, пока не замечено отпускание.
alarm-contact-remedy = Верните кнопку в исходное положение; если неисправность осталась, проверьте контакт.
alarm-zone-disabled = Зона { $subject } отключена: не в автоматическом режиме, прекращена или заблокирована.
alarm-zone-disabled-cause = Команда человека.
alarm-zone-disabled-consequence = Пожар даёт только тревогу; вода — только вручную, если вообще возможна.
alarm-zone-disabled-remedy = Наблюдайте за зоной. Затем верните автоматический режим, сбросьте зону или снимите блокировку.
alarm-zone-not-ready = Зона { $subject } не готова: сама она пуска не даст.
alarm-zone-not-ready-cause = Отказало слишком много её извещателей либо её не может обслужить ни один ствол.

# The page that replaces the console where it was not built.
console-not-built = Сервер объекта работает, но пульт в программу не встроен
console-not-built-remedy = Соберите пульт этими командами, затем заново программу. API работает и без него.

# What the API refuses.
answers-too-many = Слишком много ответов ещё не принято. Повторите.
csrf-missing = Нет заголовка X-CSRF-Token или он неверен: возьмите его из /api/session.
body-unreadable = Тело запроса не читается; не более { $body_max } байт.
not-understood = Не понято: { $error }. См. /api/openapi.json.
login-first = Сначала войдите.
host-unknown = У сервера объекта нет такого имени. Добавьте его в names раздела [server] или используйте адрес.
origin-unknown = Запрос от другой страницы. Если это допустимо, добавьте её в origins раздела [server].
jets-too-many = Не более { $jets_max } струй в запросе.
toward-wrong = toward — max или min.
no-parquet = Этот lafet собран без Parquet. Возьмите /api/history.csv или соберите с возможностью parquet.
encoding-refused = Сервер объекта принимает тела запросов только без сжатия (без Content-Encoding).
past-too-long = Не более 24 часов за раз.
seconds-range = seconds: допустимо { $from }…{ $to }.
recording-not-frames = Это не запись кадров: { $error }.
upload-broken = Файл не дошёл: { $error }.
upload-too-large = Файл слишком велик; не более { $megabytes } МиБ.
shelve-range = Нужны причина (1…{ $reason_max } символов) и 1…{ $shelve_max_min } минут.
reason-control = В причине недопустимы переводы строк и другие управляющие символы.
times-wrong = from_ms не может быть больше to_ms, и оба — больше { $time_max_ms }.
no-password = Пароль есть только у того, кто вошёл с паролем.
sim-at-or-name = Нужно at или name.
sim-out-of-range = { $name } = { $value } вне диапазона { $from }…{ $to }.
subscribed-too-many = Не более { $subscribed_max } стволов; без списка — все.
detector-kind-differs = kind не такой, как в конфигурации. Исправьте hub.toml или извещатель, который сообщает сюда.
detector-place-range = Допустимо: bearing_deg 0…360, elevation_deg −90…90, quality 0…1.
wind-range = Допустимо: from_deg 0…360, speed_mps 0…40.
check-supply = В `[supply]` нужно `pressure`; или `static`, `flow` и `pressure`; или `curve`.
check-flowing = `flowing` в `[supply]` не от 1 до { $most }.
check-winds-too-many = Ветров больше { $most }.
check-planned-remedy = (Пределы всех ключей — в docs/coverage.ru.md.)
check-obstacles = Планировщик зон принимает не больше { $most } резервуаров и стен вместе: при большем числе он не назначает стволов.

# The clock.
clock-stepped = Часы переведены на { $by_s } с, либо машина спала.

# Requests.
only-set-param = `save` — только для SetParam.
request-too-long = Запрос слишком длинный.
bus-controller-own = Этот запрос — только для контроллера магистрали.

# What is wrong with hub.toml, and what to write.
check-open-without-login = login = false, но { $listen } доступен с других машин.
check-open-without-login-remedy = Задайте login = true или слушайте на 127.0.0.1.
check-plain-passwords = Пароли передавались бы на { $listen } открыто.
check-plain-passwords-remedy = Добавьте [tls] с cert и key либо, за прокси с TLS, plain_http = true.
check-file-readable = Файл { $name } может прочитать любой пользователь этой машины.
check-listen = `{ $text }` — не адрес.
check-listen-remedy = Напишите АДРЕС:ПОРТ, например 127.0.0.1:8480 или 0.0.0.0:8480.
check-pem-files-remedy = sslrootcert, sslcert и sslkey — файлы PEM; относительный путь — от папки этого файла.
check-out-of-range = { $name } = { $value } вне допустимых значений.
check-out-of-range-remedy = Допустимо { $from }…{ $to }.
check-client-roles = client_roles без client_ca.
check-client-roles-remedy = Добавьте client_ca — файл сертификата, которым подписаны клиенты.
check-pem-remedy = Укажите путь к файлу PEM; относительный путь — от папки этого файла.
check-input-no-zone = Зоны для него нет.
check-input-no-zone-remedy = Добавьте [[zone]] или удалите вход.
check-output-no-zone-remedy = Добавьте [[zone]] или удалите выход.
check-target = `{ $text }` не указывает, что писать.
check-target-table = `{ $text }`: discrete и input только читаются.
check-target-no-value = `{ $text }`: не указано, какой бит или какие значения регистра.
check-target-same = `{ $text }`: значения «включено» и «выключено» одинаковы.
check-target-remedy = Напишите coil:12, holding:100.3, holding:100=1/0 или holding:100&0x00FF=0x0012/0: значения «включено» и «выключено»; знак ! впереди инвертирует.
check-same-target = { $id } и { $other } пишут { $bit }: один отменял бы другого.
check-same-target-remedy = Дайте каждому выходу свой бит.
check-target-alarms = { $id } пишет { $bit }, а он читается как { $other }: сервер вызывал бы сигнал сам.
check-target-alarms-remedy = Исправьте unit и бит одного из них.
check-own-feedback = { $id } пишет { $bit } и его же читает как подтверждение: в нём то, что записано, а не то, что произошло.
check-own-feedback-remedy = Укажите бит концевого выключателя или реле либо удалите его: записанное и так читается обратно.
check-part-unread = { $id } пишет часть регистра: не прочитав его, остальное не сохранить.
check-part-unread-remedy = Удалите read_back = false или отдайте выходу весь регистр: holding:100=1/0.
check-unconfirmed = Ничто не показывает, выполнил ли { $id } команду.
check-unconfirmed-remedy = Удалите read_back = false или укажите бит обратной связи: on.
check-single-reading = { $id } пускал бы по одному чтению.
check-single-reading-remedy = Укажите debounce_ms не меньше { $least } (не больше 1000) или poll_ms у { $name } поменьше.
check-bus-name = `{ $name }` — не имя линии.
check-bus-name-remedy = Допустимо 1…32 латинских букв, цифр, - и _.
check-bus-twice = { $name } указано дважды.
check-bus-twice-remedy = Имена линий различны.
check-bus-same-line = На этой же линии — { $name }.
check-bus-same-line-remedy = Линия — один раздел [[modbus]] со всеми её устройствами.
check-bus-with-monitor = На этой линии — ствол со своим протоколом.
check-bus-with-monitor-remedy = Отведите извещателям отдельную линию.
check-bus-unknown = Линии { $name } нет.
check-bus-unknown-remedy = Добавьте [[modbus]] с name = "{ $name }" или исправьте имя.
check-key-meaningless = { $key } здесь не имеет смысла.
check-key-meaningless-remedy = При map = "fv300" — register, axis, field; при map = "notifier" — register; без map — alarm и другие биты, heartbeat_s — вместе с heartbeat.
check-axis-and-field = axis и field указываются вместе.
check-view = Так извещатель не установить.
check-register-missing = Не хватает register.
check-register-missing-remedy = Укажите регистр точки, считая с 0.
check-alarm-bit-missing = Не указан бит тревоги.
check-alarm-bit-missing-remedy = Напишите alarm = "discrete:12" или map = "fv300".
check-heartbeat = heartbeat без heartbeat_s.
check-heartbeat-remedy = Укажите heartbeat_s: вдвое больше времени, за которое бит меняется, с.
check-same-bit = У { $id } и { $other } один бит тревоги ({ $bit }): одно устройство голосовало бы дважды.
check-same-bit-remedy = Исправьте unit и бит или удалите один из них.
check-one-unit = Все голоса для пуска зоны { $zone } может дать одно устройство { $unit } на { $bus }, а его неисправность ничем не видна: если оно выдаст неверные биты, пойдёт вода.
check-one-unit-remedy = Задайте извещателям heartbeat или fault либо подключите часть к другому устройству.
check-same-reading = { $id } и { $other } читают один и тот же бит ({ $bit }) устройства { $unit } на { $bus }: одно из двух указано неверно.
check-same-reading-remedy = Исправьте unit и бит или удалите один из них.
check-silent-too-soon = { $id } считается молчащим через { $silent } мс, а на две попытки { $name } нужно { $own } мс.
check-silent-too-soon-remedy = Уменьшите poll_ms или timeout_ms у { $name } или укажите silent_after_s не меньше { $least }.
check-bus-unused = На линии { $name } ничего нет: раздел остался бы без действия.
check-bus-unused-remedy = Напишите в [[detector]] или [[input]] source = { "{" } modbus = "{ $name }", unit = 1, … { "}" }, в [[output]] или [[pump]] target = … или удалите линию.
check-round-too-long = Один обход { $name } занимает на этой скорости { $round } мс — больше poll_ms = { $poll_ms }.
check-round-too-long-remedy = Укажите poll_ms не меньше { $poll_ms }, скорость выше или разделите линию.
check-view-remedy = Напишите axis = [пеленг 0…360, угол места −90…90] и field = [ширина, высота], 1…180, всё в градусах.
check-example-remedy = Что здесь может стоять: lafet serve --example.
check-no-monitor = Не указан ни один ствол.
check-no-monitor-remedy = Добавьте: [[monitor]], id = "M1", url = "tcp://192.168.1.50?addr=1".
check-monitor-id = `{ $id }` — не id.
check-monitor-id-remedy = Допустимо 1…32 латинских букв, цифр, - и _; для людей служит name.
check-monitor-twice = { $id } указан дважды.
check-monitor-twice-remedy = id стволов различны.
check-no-simulator = В сервере объекта нет имитатора.
check-no-simulator-remedy = Запустите `lafet sim` и укажите напечатанный адрес.
check-same-url = { $url }: два ствола с одним URL.
check-same-url-remedy = Дайте каждому свой адрес: ?addr=2.
check-url-remedy = Напишите tcp://УЗЕЛ:ПОРТ?addr=1, udp://… или serial:///dev/ttyUSB0?baud=19200.
check-host-name = `{ $name }` — не имя.
check-host-name-remedy = Напишите только имя: hub.site.example, без http:// и порта.
check-origin = `{ $text }` — не origin.
check-origin-remedy = Напишите https://ИМЯ или https://ИМЯ:ПОРТ, без пути; * не допускается.
check-keep-out-name = Имя запретного сектора «{ $name }» не подходит.
check-keep-out-name-remedy = Дайте каждому запретному сектору своё имя из 1…{ $most } знаков.
check-keep-out-angles = Запретный сектор «{ $name }» задан неверно.
check-keep-out-angles-remedy = Азимуты — −360…360°, от и до по часовой стрелке; углы возвышения — −90…90°, сначала меньший.
check-keep-out-narrow = У запретного сектора «{ $name }» нет ширины или высоты: он защитил бы одну линию.
check-keep-out-narrow-remedy = Укажите два разных азимута, от первого ко второму по часовой стрелке, и два разных угла возвышения; весь круг — bearings = [0, 360].
check-keep-out-monitor = Запретный сектор «{ $name }» задан для ствола { $monitor }, который не описан.
check-keep-out-monitor-remedy = Укажите id из [[monitor]] или уберите monitor: тогда сектор действует для всех стволов.
check-keep-out-place = Запретный сектор «{ $name }» действует для { $monitor }, а где стоит этот ствол, не указано.
check-keep-out-place-remedy = Азимуты отсчитываются от севера: укажите для { $monitor } at, heading и height.
check-keep-out-aim = { $monitor } наводится на зону { $zone } туда, где запретный сектор «{ $name }».
check-keep-out-aim-remedy = Наведите иначе или исправьте сектор: вода туда не подаётся.
check-keep-outs-too-many = Запретных секторов больше { $most }.
check-keep-outs-too-many-remedy = Объедините соприкасающиеся секторы.
check-plan = Этого на плане быть не может.
check-plan-remedy = Место — метры в пределах 100 км, направление −360…360°, высота 0…1000 м, диаметр больше 0.
toml-unknown = { $name } здесь неизвестно; возможно: { $known }.
toml-not-one-of = { $name } здесь недопустимо; возможно: { $known }.
toml-missing = Не хватает { $name }.
toml-twice = Это указано дважды.
toml-no-vote = { $votes } — не число голосов: напишите 2oo3, то есть два из трёх извещателей.
toml-meant = Возможно, имелось в виду { $name }.
check-no-driver = [[{ $table }]]: драйвера нет, таблица осталась бы без действия.
check-no-driver-remedy = Удалите её или укажите входу `source`, выходу или насосу `target` на [[modbus]]. Отмена, удержание и пуск есть и по HTTP.
check-aims = зона { $id }: наведений ствола { $monitor } — { $count }, а нужно одно.
check-aims-remedy = Напишите один раздел [[aim]]: zone = "{ $id }", monitor = "{ $monitor }", horizontal, vertical и nozzle.
check-poll-seldom = { $name } обслуживает зону { $id }: слишком редко для подтверждения Close.
check-poll-seldom-remedy = Укажите не больше { $poll_ms_max }.
check-not-served = Ствол { $name } не обслуживает зону { $of }.
check-not-served-remedy = Исправьте zone и monitor или укажите ствол в `monitors` зоны.
check-aim = Так навести ствол нельзя.
check-aim-remedy = program — 0…7, horizontal и vertical — −21600…21600 угловых минут, nozzle — мм от 0.
check-station = Там извещатель стоять не может, или погрешность его пеленгов не может быть такой.
check-station-remedy = at = [восток, север, высота] в метрах в пределах 10 км, error_deg — от { $least } до { $most }.
check-no-place = error_deg относится к извещателю, место которого не указано.
check-no-place-remedy = Укажите также at = [восток, север, высота] в метрах или удалите её.
check-stations-too-many = зона { $zone }: извещателей с указанным местом больше { $most }.
check-stations-too-many-remedy = Удалите `at` у тех, которые дают меньше всего: трёх мест вокруг зоны хватает, чтобы отличить два пожара от ложных пересечений.
toml-kind = Указано: { $given }, а нужно: { $wanted }.
toml-kind-value = { $kind }{ $value }
check-zones = { $place }: { $what }

# Motion by hand.
jog-axes = Вручную ведутся только Vertical, Horizontal и Nozzle.
jog-taken-over = Приводом управляет { $by }.
jog-still-moving = Привод движется, несмотря на Stop. Используйте аварийный останов.
jog-unbounded = Контроль пределов выключен, и при обрыве связи ствол не прекратит движение сам. Включите пределы или задайте MoveTimeout подсистемы General, например 500 мс.

# Errors of the API.
no-monitor = Ствола { $id } нет.
nothing-stopped = Ствола { $id } нет: ничего не остановлено и не закрыто. Возможно, его переименовали: перезагрузите страницу. POST /api/stop останавливает все стволы.
no-zones = Зоны не настроены. См. docs/installation.ru.md.
no-detector = Извещателя { $id } нет. Добавьте его в конфигурацию или исправьте имя.
detector-on-bus = Извещатель { $id } читается по линии { $bus }. Чтобы сообщать о нём здесь, удалите `source` в hub.toml.
order-void = Команда отозвана до отправки.
sent-in-future = `up_ms` больше, чем у сервера: прибавьте к `up_ms` его сообщения время, прошедшее с тех пор.
request-late = Команда шла слишком долго и не выполнена. Если она ещё нужна, отправьте её снова; если это повторяется, перезагрузите страницу.
beat-late = Сигналы удерживаемого органа управления приходят с опозданием: сеть или компьютер были заняты. Отпустите его и нажмите снова.
confirm-needed = Нужно "confirm": "{ $id }", чтобы это не сделали по ошибке.
nothing-here = Здесь ничего нет. См. /api/openapi.json.
role-needed = Нужна роль «{ $role }».
session-ended = Сеанс завершён: ещё десять минут работает только «Стоп». Войдите снова.
too-fast = Слишком часто. Повторите через { $wait_s } с.
control-held = { $monitor } управляет { $user }. Запросите управление или подождите.
control-free = { $monitor } никем не управляется. Сначала возьмите управление.
control-not-asked = Никто не запрашивает управление.
force-needs-reason = Для принудительного захвата нужна причина, не короче 5 знаков.
keep-out-met = Запретный сектор «{ $name }»: воду туда подавать нельзя. Отведите ствол при закрытых затворах или выберите другое направление.
keep-out-unknown = Запретный сектор «{ $name }»: куда направлен ствол, неизвестно, и вода может попасть туда. Остановите ствол, проверьте его положение, пределы и связь.
not-connected = Нет соединения с { $monitor }. Ничего не отправлено.
no-answer-within = { $monitor } не отвечает { $seconds } с. Проверьте связь с ним и повторите запрос.
postgres-away = PostgreSQL, где хранится история, не отвечает. Проверьте этот сервер.
postgres-failed = PostgreSQL, где хранится история: { $error }. Проверьте этот сервер.
storage-failed = Хранилище не работает: { $error }. Проверьте диск.
store-engine = сообщение SQLite: { $error }
store-away = PostgreSQL не отвечает
store-busy = слишком многое ждёт записи на диск
store-unread = диск не дал прочитать файл при запуске сервера объекта
store-in-use = папкой { $folder } пользуется другой сервер объекта
store-newer = Состояние в { $folder } записано lafet { $program } (формат { $format }); это lafet { $own }, известны форматы до { $known }. Ничего не изменено. Установите снова lafet { $program } или новее либо восстановите копию папки, сделанную до обновления.
store-newer-unknown = Состояние в { $folder } записано более новой версией lafet (формат { $format }); это lafet { $own }, известны форматы до { $known }. Ничего не изменено. Установите ту версию снова либо восстановите копию папки, сделанную до обновления.
store-zones = сохранённое состояние зон не читается: { $error }
store-shared = в папку { $folder } могут писать другие пользователи этой машины, и в ней есть чужие файлы
store-no-room = в папку { $folder } ничего нельзя записать ({ $error }). Для первого запуска серверу объекта нужен там хотя бы 1 МБ, а с резервом — 40 МБ. Ничего не начато: освободите место или выберите другую папку (data) и запустите снова.
store-file = { $file }: { $error }
login-failed = Неверный пользователь, пароль или ссылка. С каждой ошибкой ждать дольше.
access-conflict = Такой уже есть, либо это последний администратор.

# Buses of detectors: events.
bus-open = Modbus { $name }: линия открыта.
bus-lost = Modbus { $name }: нет соединения. { $why }
bus-reading = { $sort } { $id } (modbus { $bus }, устройство { $unit }): { $news }.
bus-detector = Извещатель
bus-input = Вход
bus-output = Выход
bus-pump = Насос
bus-output-fault = сработал его контакт неисправности
bus-output-dropped = устройство потеряло команду, как после перезапуска; она повторяется, если ещё нужна
bus-output-refused = устройство отклоняет запись
bus-reading-lost = нет верного ответа, неисправность
bus-reading-frozen = признак работы не меняется, неисправность
bus-reading-back = снова читается

# Buses of detectors: their lines.
check-line = `{ $url }` — не линия.
check-line-remedy = Напишите tcp://10.0.0.9:502, rtu+tcp://10.0.0.9:4001 или serial:///dev/ttyUSB1?baud=19200&parity=even.
check-line-option = `{ $url }`: { $name } так указать нельзя.
bus-takes-nothing = Байты не принимаются.

# Buses of detectors: addresses of bits.
check-point-one-bit = `{ $text }`: coil и discrete — это один бит, бит и маска не указываются.
check-point-no-bit = `{ $text }`: не указан бит регистра.
check-point-remedy = Напишите discrete:12, coil:12, holding:100.3 или input:100&0x00F0=0x0020: адрес считается с 0, бит — 0…15, знак ! впереди инвертирует.
check-point = `{ $text }` не называет бит.
check-point-address = `{ $whole }`: адрес — не 0…65535.
check-point-bit = `{ $whole }`: бит — не 0…15.
check-point-mask = `{ $whole }`: в значении есть биты вне маски, или маска пуста.

# Buses of detectors: answers.
bus-no-answer = Нет ответа в срок.
bus-other-unit = Вместо него ответило устройство { $unit }.
bus-other-function = Ответ на функцию { $function }, которую не запрашивали.
bus-other-count = В ответе не столько значений, сколько запрошено.
bus-other-value = Ответ подтверждает не то значение, которое записано.
bus-given-up = Ответа не ждали: пришла команда.
bus-no-frame = Принятое — не кадр Modbus. Проверьте скорость, чётность и другой конец линии.
bus-exception = Исключение { $code }: { $why }.
bus-function = функция не поддерживается
bus-address = нет такого адреса
bus-value = значение отклонено
bus-device = отказ устройства
bus-busy = устройство занято
bus-no-path = шлюз: нет пути
bus-behind-gateway = шлюз: устройство не отвечает
bus-unknown-code = нет в стандарте

# Control.
reason-too-long = reason — не длиннее { $reason_max } символов.
action-unknown = `{ $action }` — не { $list }.
control-expired = { $monitor }: управление { $user } потеряно, приводы остановлены.

# State of a monitor.
link-connected = Соединение восстановлено.
link-lost = Нет соединения: { $error }.
check-link-remedy = Проверьте питание, кабель и адрес в конфигурации.
link-down = Нет соединения.
barrel-stowed = Ствол в дежурном положении.
barrel-stowed-remedy = Разверните; поиск и тушение разворачивают ствол сами.
no-move-hold = У ствола нет параметра MoveHold: если при ручном перемещении откажет сервер объекта или связь, привод остановится примерно через 2 с, а не в пределах 0,5 с.
no-move-hold-remedy = При ручном перемещении держите аппаратный аварийный останов под рукой; прошивка с MoveHold прекращает движение раньше.

# Jets.
jet-value-needed = Без ствола нужно значение { $name }.
jet-target-range = way_m — 0…{ $way_max_m } м, rise_m — −{ $way_max_m }…{ $way_max_m } м.

# State of the hub.
audit-changed = Журнал аудита изменён: запись { $n } не та, что была сделана.
state-missing = { $name } отсутствует или пуст, остальные файлы состояния на месте.
state-foreign = { $name } не от этого объекта: он из другой папки или копии.
state-cut = { $name } укорочен или это старая копия: записей { $found }, должно быть не менее { $noted }.
state-changed = { $name } изменён: запись { $n } не та, что была отмечена.
state-altered = пользователи или токены в { $name } не те, что оставил сервер объекта, и в журнале аудита об этом нет записи: их изменила другая программа либо сервер был оборван в этот момент. Сверьте их с журналом аудита.
state-no-users = { $name } без пользователей, хотя они были.
state-unread = Диск не даёт прочитать { $name }: { $error }. Сервер объекта работает без его содержимого и не меняет его. Исправьте диск или связь с ним, затем перезапустите сервер объекта.
state-malformed = { $name } не читается: { $error }.
state-set-aside = { $name } не читался: { $error }. Он сохранён под именем { $aside }, на его месте новый.

# PostgreSQL.
no-postgres = Этот lafet собран без PostgreSQL.
no-postgres-remedy = Уберите url — будет SQLite; либо соберите с возможностью postgres.
postgres-sslmode = Нет sslmode={ $other }.
postgres-sslmode-remedy = Напишите disable, allow, prefer, require, verify-ca или verify-full.
postgres-address = Это не адрес PostgreSQL.
postgres-address-remedy = Напишите postgres://ИМЯ:ПАРОЛЬ@УЗЕЛ/БАЗА либо уберите url — будет SQLite.
postgres-verify-by-what = Сервер надо проверять, но не указано, по чему.
postgres-verify-by-what-remedy = Добавьте sslrootcert=ФАЙЛ (сертификат, которым он подписан) либо sslrootcert=system.
postgres-system-not-full = sslrootcert=system без verify-full: такой сертификат может получить кто угодно.
postgres-verify-full-remedy = Напишите sslmode=verify-full.
postgres-verifies-nothing = sslrootcert указан, но с таким sslmode ничего не проверяется.
postgres-cert-and-key = sslcert и sslkey нужны вместе.
postgres-cert-and-key-remedy = Укажите оба или ни одного.
postgres-no-authority = Эта машина не доверяет ни одному центру (Debian: apt install ca-certificates).

# Events of the zones.
zones-not-stored = Режимы, отключения и запреты зон не сохраняются и пропадут при перезапуске. Проверьте диск.
water-timeout-off = WaterTimeout — 0: при отказе сервера объекта ствол сам не прекратит воду зоны { $zone }. Задайте { $most } с.
water-timeout-longer = WaterTimeout — { $seconds } с, больше water_max_s зоны { $zone } ({ $most } с): при отказе сервера объекта вода пойдёт дольше, чем положено зоне. Задайте { $most } с.
zones-stored = Режимы, отключения и запреты зон снова сохраняются.
zones-no-wind = От анемометра { $minutes } мин нет показаний: стволы назначаются по последнему ветру.
zones-wind-known = Стволы назначаются по ветру, сообщённому последним: { $speed } м/с, направление { $from }°.
zones-wind-unknown = О ветре сообщений не было: стволы назначаются как при штиле. Единственный запас на ветер: пожар считается досягаемым до { $percent } % дальности струи.
zone-detector-alarm = Извещатель { $detector }: тревога ({ $by }).
zone-countdown = Зона { $zone }: голосов достаточно, пуск через { $seconds } с.
zone-held = Зона { $zone }: задержка удерживается.
zone-hold-over = Зона { $zone }: удержание окончено.
zone-water-found = { $monitor }: при запуске сервера шла вода; закрытие через { $seconds } с.
zone-water-gone = { $monitor }: в файле больше нет зоны с этим стволом, а вода может идти; закрытие через { $seconds } с.
zone-water-lost = В файле больше нет ствола { $monitor }, а вода может идти: закройте его вручную.
zone-monitor-replaced = Зона { $zone }: ствол { $monitor } используется вместо другого.
why-lockout = аварийная блокировка
why-abort = отмена
why-duration = наибольшая длительность
why-quiet = тревог нет
why-test-over = испытание окончено
why-votes = мало голосов
why-mode = не в автоматическом режиме
mode-automatic = автоматический режим
mode-manual = ручной режим
mode-off = отключена
mode-test-dry = испытание без воды
mode-test-outlet = испытание выпуска
zone-news = Зона { $zone }: { $news }.
zone-stored-mode = Зона { $zone } начинает так, как сохранено: { $stored }. В файле: { $file }.
zone-stored-gone = В файле больше нет: { $what }; сохранённое для него (режим, отключение, запрет или остановка насоса вручную) не действует.
zone-station-refused = Пост пуска { $input }: пуска зоны { $zone } нет. { $why }
zone-cancelled = Зона { $zone }: отсчёт прекращён ({ $why }).
zone-ended = Зона { $zone }: пуск прекращён ({ $why }).
zone-no = { $scope }: { $why }; действует до сброса.
zone-reset = { $scope }: сброс.
zones-lockout-on = Зоны: аварийная блокировка включена.
zones-lockout-off = Зоны: аварийная блокировка снята.
zone-not-planned = Зона { $zone }: назначить стволы на очаги не удаётся ({ $why }). Первыми идут ближайшие; проверьте план объекта в hub.toml.
zone-planned = Зона { $zone }: стволы снова назначаются на очаги.
zone-trouble = { $subject }: { $trouble }.
zone-trouble-over = { $subject }: { $trouble }, устранено.
released-dry = испытательный пуск, без воды
released-by-votes = пуск по голосам извещателей
released-by-hand = ручной пуск
scope-site = Все зоны
scope-zone = Зона { $zone }

# Files of certificates and keys.
file-wrong = { $path }: { $what }.
file-no-certificate = в нём нет сертификата
file-no-key = в нём нет закрытого ключа
file-unreadable = не читается: { $error }
file-no-pem = не PEM: { $error }
file-useless = не годится: { $error }

# Kinds of values in hub.toml: what is needed, what is given.
kind-a-string = текст в кавычках
kind-a-boolean = true или false
kind-a-list = список: [[…]] или […]
kind-a-table = таблица
kind-whole = целое число
kind-whole-from-0 = целое число от 0
kind-a-number = число
kind-a-path = путь в кавычках
kind-two-numbers = два числа: [восток, север]
kind-integer = число
kind-fraction = дробь
kind-string = текст
kind-boolean = значение

# Figures of a link.
figure-sent = Кадров отправлено за секунду
figure-received = Кадров получено за секунду
figure-retries = Кадров повторено за секунду
figure-timeouts = Ответов не пришло за секунду
figure-errors = Ошибочных кадров за секунду
figure-rtt = Сглаженное время ответа
figure-ms = мс

# Alarms of flags: what follows.
flag-drive = Оси нельзя доверять: она останавливается и может не двигаться, струю не навести.
flag-deployer = Ствол может остаться свёрнутым: тогда нельзя ни наводить, ни подавать воду.
flag-heating = На морозе узел может замёрзнуть и перестать двигаться.
flag-remote = Параметры удалённого устройства могут отличаться от показанных.
flag-button = Эта кнопка поста не действует; остальные работают.
flag-config-fault = Подсистема работает с исходными значениями: пределы и нулевая точка могут быть неверны.
flag-config-invalid = Подсистема может не работать, пока параметры не заданы полностью.
flag-config-write-fault = Заданное пропадёт при отключении питания.
flag-conn-lost = Ствол не может управлять этим устройством: оно остаётся как есть.
flag-bad-power = Приводы и затворы могут замедлиться, остановиться или не работать.
flag-internal-fault = Работа подсистемы прервана; тушение могло остановиться.
flag-wdt-fault = Устройство было перезапущено: его работа прервана.
flag-protocol-fault = Часть команд не доходит до устройства.
flag-pressure-sensor = Давление неизвестно; программы наводят без баллистики, возможен недолёт струи.
flag-locked-out = Всё остановлено, затворы закрыты; команды отклоняются.
flag-heating-sensor = Обогрев этого узла не регулируется: на морозе он может замёрзнуть.
flag-valve-overload = Затвор остановился в пути: он может быть открыт не полностью или не закрыт.
flag-drive-overload = Привод остановлен и не движется в эту сторону, пока флаг не снят.
flag-limitless = Ничто не удерживает ствол от удара об упоры.
flag-blocked = Затвор не открывается по команде.
flag-valve-sensors = Неизвестно, открыт затвор или закрыт.
flag-outside-limits = Часть очага не орошается.
flag-mode-fault = Программа не выполняется.
flag-trajectory = Ствол наводится прямо на цель: на большой дальности струя не долетает.
flag-found = В секторе поиска есть горение.
flag-device-fault = Ствол не находит очаги: наблюдать и наводить нужно вручную.
flag-bad-sector = Поиск не выполняется.
flag-dirty-lens = Небольшие или далёкие очаги могут быть не замечены.

# Tuning of a drive.
tune-drives = Настроить можно только Horizontal, Vertical и Nozzle.
tune-put-back = { $drive }: настройка была прервана; StopLag и MinSpeed снова прежние.
tune-not-put-back = { $drive }: настройка была прервана, вернуть прежние StopLag и MinSpeed не удалось: { $error }
tune-not-written-back = { $drive }: не удалось записать StopLag и MinSpeed, бывшие до настройки: { $error }
tune-not-stored = ствол не смог записать ЭНОЗУ (ConfigWriteFault), они действуют до сброса. Проверьте его питание.
tune-note-bad = Неизвестно, что изменила прерванная настройка: { $file }: { $error }. Проверьте StopLag и MinSpeed приводов, затем удалите файл.
tune-not-noted = Прервано: прежние значения нельзя записать на диск: { $error }.
tune-running = Привод этого ствола уже настраивается.
tune-interrupted = Прервано: СТОП или другая команда стволу.
tune-ended = Прервано оператором.
tune-authority-lost = Прервано: управление стволом потеряно.
tune-page-gone = Прервано: страница, которая начала настройку, не отвечает.

# Updates of monitors' software: what is refused.
updates-run-already = Обновление уже идёт, его начал { $user }. Дождитесь конца или остановите его.
updates-none-runs = Обновление не идёт.
updates-images-number = Укажите один образ или два: один для области A и один для области B.
updates-image-missing = На сервере нет образа { $digest }. Сначала загрузите его.
updates-not-a-set = Два образа должны быть одной версии и для одной платы: один собран для области A, другой для области B.
updates-pace-range = pace: от 1 до 100 процентов времени линии
updates-no-monitors = Обновлять нечего: стволов нет.
updates-images-full = На сервере уже { $most } образов. Удалите ненужный.
updates-image-in-use = Этот образ сейчас посылается. Дождитесь конца обновления или остановите его.
updates-image-differs = На сервере есть образ с теми же данными и другим заголовком: версия { $version } для { $board }. Сначала удалите его.
updates-image-unusable = Образ { $digest } непригоден: { $error } Удалите его и загрузите снова.
updates-order-refused = ПО ствола { $monitor } обновляется: до конца передаются только Stop, Close и аварийная блокировка. Если ствол нужен, сначала остановите обновление.

# Why a monitor is not updated.
updates-not-stowed = Он не в дежурном положении: сверните его и дождитесь, пока он свернётся.
updates-valve-open = { $valve } не закрыт: закройте его и дождитесь, пока он закроется.
updates-drive-moves = { $drive } движется: дождитесь покоя или остановите его.
updates-bad-supply = Напряжение питания вне диапазона (BadPower): проверьте питание.
updates-general-silent = General не сообщает состояние: проверьте ствол.
updates-program-runs = Он выполняет программу: дождитесь её конца или остановите её.
updates-tuning-runs = Настраивается один из его приводов: дождитесь конца.
updates-fire-found = Его извещатель обнаружил очаг загорания.
updates-zone-not-quiet = Зона { $zone } не в покое: дождитесь конца тревоги и пуска и сбросьте её.
updates-other-silent = { $other } не отвечает, а он тоже обслуживает зону { $zone }: два ствола зоны не должны быть выведены из работы одновременно. Дождитесь его ответа.
updates-other-locked = { $other } заблокирован, а он тоже обслуживает зону { $zone }: два ствола зоны не должны быть выведены из работы одновременно. Сначала снимите его блокировку.
updates-not-locked = Аварийная блокировка не включилась: { $error }
updates-lockout-not-stored = Аварийная блокировка включена, но не записана: после потери питания она была бы снята. Проверьте, нет ли у General флага ConfigWriteFault.
updates-word-not-noted = То, что подтвердит обновление, нельзя записать на диск сервера: { $error }. Ничего не отправлено: проверьте диск.
updates-no-random = В системе нет случайных байтов для обновления: { $error }. Ничего не отправлено.
updates-other-image = У него есть другой образ, который назначен или на пробе и послан этим сервером. Обновите ствол тем образом, чтобы подтвердить его, или подождите, пока ствол сам вернётся к старой версии, 180 с после запуска.
updates-sent-elsewhere = У него есть образ, который назначен или на пробе и послан не этим сервером, поэтому здесь нечем его подтвердить. Обновите ствол оттуда, откуда он послан, или подождите, пока ствол сам вернётся к старой версии, 180 с после запуска.
updates-note-unreadable = У него есть образ, который назначен или на пробе, а то, что его подтвердит, не прочитать из { $file }. Подождите, пока ствол сам вернётся к старой версии, 180 с после запуска, или перезапустите его. Затем повторите обновление.
updates-not-released = Версия { $to } подтверждена, но аварийную блокировку снять не удалось: { $error }

# What follows.
updates-lockout-stays = Аварийная блокировка, включённая обновлением, остаётся: снимите её, когда ствол снова понадобится.
updates-lockout-of-others = Тем временем ствол заблокировал другой клиент: эта блокировка остаётся.
updates-goes-on = Принятое остаётся в стволе: то же обновление продолжит с этого места.
updates-goes-back = Новая версия на пробе: если то же обновление не начать раньше, ствол вернётся к старой через 180 с после запуска.
updates-confirmed-yet = Версия { $to } подтверждена.

# Why a run has ended.
updates-stopped = Остановлено: { $user }.
updates-rights-lost = Прервано: права пользователя { $user } закончились.
updates-hub-ends = Прервано: сервер завершает работу.
updates-monitor-replaced = Прервано: у сервера теперь другие стволы.
updates-zone-alarm = Прервано: зона { $zone } больше не в покое.
updates-failed-at = { $monitor } не обновлён; следующие за ним остались прежними.
updates-broken = Прервано из-за ошибки сервера: какой, сказано в его журнале.

# Updates: events.
updates-event-restarts = Перезапускается с версией ПО { $to }, на пробе.
updates-event-done = ПО обновлено с { $from } до { $to }.
updates-event-confirmed = ПО { $to } подтверждено.
updates-event-failed = ПО не обновлено: { $why }

# The Modbus server: events.
plug-listening = Сервер Modbus { $name } принимает подключения: { $url }.
plug-not-listening = Сервер Modbus { $name } не принимает подключений: { $why }
plug-port-lost = Последовательный порт пропал.
plug-heartbeat-lost = Пропал сигнал исправности мастера { $master } ({ $from }): начатые им движения прекращаются, управление он теряет, если не вернётся.
plug-not-closed = Потерян { $client } ({ $from }), и ствол { $monitor } не подтвердил закрытие { $valve }: команда закрыть повторяется каждую секунду, не дольше десяти минут.
plug-not-stopped = Потерян { $client } ({ $from }), и ствол { $monitor } не подтвердил остановку { $drive }: команда «Стоп» повторяется каждую секунду, не дольше десяти минут.

# The Modbus server: why a command is refused, by number.
plug-no-command = Команды с таким номером нет. См. список команд.
plug-no-monitor = Ствола с таким номером в этом устройстве нет. Номер — от 1 до значения регистра monitors.
plug-argument = Аргумент вне допустимых значений. См. список команд.
plug-session = Номер сеанса — не нынешний. После каждого подключения и каждой потери сигнала исправности читайте session.number и записывайте его с каждой командой.
plug-heartbeat = Сигнал исправности мастера не поступает. Меняйте регистр heartbeat чаще, чем session.heartbeat_limit, и дождитесь session.live = 1.
plug-role = По hub.toml этому мастеру разрешено только чтение. Стоп, закрытие и аварийная блокировка принимаются всё равно.
plug-held = Управление у другого клиента. Запросите его командой 3 или дождитесь, пока оно освободится.
plug-not-taken = Управление ни у кого. Сначала возьмите его командой 1.
plug-key = Ключ — не тот, что предлагается сейчас. Прочтите ключ этого ствола и запишите его один раз.
plug-busy = У предыдущей команды ещё нет результата. Дождитесь его.
plug-sequence = Этот номер уже был у другой команды. С каждой командой записывайте новый номер.
plug-refused = Ствол отказал; его результат (§2/5) — в регистре status.
plug-no-answer = Ствол не ответил. Проверьте его питание и линию.
plug-unknown = Выполнил ли это ствол, неизвестно. Прежде чем повторить, посмотрите его состояние.
plug-not-sent = Не отправлено: связи со стволом нет.
plug-keep-out = Вода могла бы попасть в запретный сектор из hub.toml. Отведите ствол при закрытых затворах.
plug-too-fast = Слишком много команд. Повторите через секунду.
plug-void = Не отправлено: пропал сигнал исправности или управление, либо раньше пришёл стоп.
plug-asked = Управление уже запрашивает другой клиент.
plug-late = Результата в срок не было; команда ещё может быть выполнена. Посмотрите состояние ствола.
plug-ended = Движение прекращено: стопом, другим клиентом или самим стволом. Начните его с новым номером.
plug-hub = Сервер объекта не смог этого сделать. См. его журнал.

# The Modbus server: commands, by number.
command-take = Взять управление, если оно свободно.
command-release = Отдать управление.
command-ask = Запросить управление; когда его передадут, покажет регистр authority.
command-go-to = Навести: в argument1 — бит на каждый движущийся привод (0 горизонталь, 1 вертикаль, 2 насадок), argument2 — горизонталь −3600…3600, argument3 — вертикаль −900…1800, argument4 — насадок 0…1000.
command-open = Открыть затвор argument1 (1 или 2) с ключом ствола.
command-close = Закрыть затвор argument1 (1 или 2); 0 — все затворы ствола.
command-stop = Остановить ствол; monitor 0 — все стволы объекта.
command-lockout = Аварийная блокировка ствола; monitor 0 — всех стволов объекта. По Modbus не снимается.
command-deploy = Развернуть ствол.
command-stow = Свернуть ствол.

# The Modbus server: registers.
map-version = Версия этой карты: другое значение — другая карта
map-life = Меняется, пока сервер объекта работает
map-monitors = Число стволов в этом устройстве
map-site = Бит 0 — извещатель видит пожар, 1 — ждёт тревога о пожаре, 2 — какая-либо тревога ждёт подтверждения
map-quality = Бит 0 — достоверно: свежее и есть связь, 1 — устарело, 2 — связи нет, 3 — ещё не было ответа; неизвестны: 4 горизонталь, 5 вертикаль, 6 насадок, 7 давление, 8 расход, 9 затворы, 10 напряжение
map-age = Возраст состояния по часам, которые не переводятся; 65534 — столько или больше, 65535 — неизвестен
map-mode = 0 неизвестно, 1 в дежурном положении, 2 разворачивается, 3 сворачивается, 4 вручную, 5 поиск, 6 тушение, 7 программа на паузе, 8 юстировка, 9 аварийная блокировка, 10 перезапуск
map-authority = Младший байт: 0 — управления ни у кого нет, 1 — у этого мастера, 2 — у другого; бит 8 — связь с тем, у кого управление, потеряна, 9 — управление запрашивают, 10 — его запрашивает этот мастер
map-horizontal = Горизонталь, влево — плюс; −32768 — неизвестно
map-vertical = Вертикаль; −32768 — неизвестно
map-nozzle = Насадок; −32768 — неизвестно
map-pressure = Давление; 65535 — неизвестно
map-flow = Расход; 65535 — неизвестно
map-valves = Младший байт — затвор 1, старший — затвор 2: бит 0 открыт, 1 закрыт, 2 открывается, 3 закрывается, 4 заблокирован, 5 неисправность, 6 есть, 7 неизвестно
map-fire = Бит 0 — извещатель видит пожар, 1 — его тревога активна или ждёт, 15 — неизвестно
map-alarms = Младший байт — число тревог; старший — худшая: 0 нет, 1 пожар, 2 высокая, 3 средняя, 4 низкая
map-state = Бит 0 — готов, 1 — аварийная блокировка, 2 — вода идёт или может идти, 3 — тревога ждёт, 15 — неизвестно
map-motion = По три бита на горизонталь, вертикаль, насадок: движется, на нижнем пределе, на верхнем пределе; бит 15 — неизвестно
map-voltage = Напряжение питания; 65535 — неизвестно
map-session = Номер этого сеанса, другой после каждого подключения и каждой потери сигнала исправности
map-role = 1 наблюдатель, 2 оператор
map-live = 1 — сигнал исправности мастера поступает
map-limit = За это время сигнал исправности должен измениться
map-losses = Сколько раз сигнал исправности в этом сеансе пропадал
map-heard = Последний принятый сигнал исправности
map-profile = 1 — эта карта
map-result-sequence = Номер команды; результат 1 — последний
map-result-state = 0 нет, 1 принята, 2 выполнена: ствол подтвердил, 3 отказ, 4 результата в срок нет
map-result-refusal = Номер отказа; 0 — нет
map-result-command = Команда
map-result-monitor = Ствол, с 1
map-result-status = Результат ствола (§2/5), если отказал он
map-jog-sequence = Номер движения
map-jog-state = Худшее из состояний приводов
map-jog-drive = 0 нет, 1 начинается, 2 движется, 3 отказ, 4 прекращено
map-key = Ключ следующего открытия на этом стволе; меняется после каждого применения, каждой потери сигнала исправности и каждого подключения
map-heartbeat = Сигнал исправности мастера: менять чаще, чем session.heartbeat_limit
map-new-sequence = Новый номер для каждой команды
map-own-session = Номер сеанса: session.number
map-of-unit = Ствол, с 1
map-direction = 1 — вверх, влево, уже, −1 — обратно, 0 — нет; движение длится, пока меняется сигнал исправности
map-command = Команда; 0 — нет
map-argument1 = Биты приводов или затвор
map-argument2 = Горизонталь
map-argument3 = Вертикаль
map-argument4 = Насадок
map-written-key = Ключ, для открытия
map-id = Имя ствола в hub.toml
map-status-word = Слово состояния { $subsystem }, старшая половина первая; все единицы — неизвестно
map-unit = Устройство { $unit }, версия карты { $version }
map-columns = адрес | имя | R/W | тип | единица | значение
map-commands = Команды
map-refusals = Отказы
map-numbers = номер | значение
vector-read-header = Мастер читает заголовок
vector-read-summary = Мастер читает сводку первого ствола
vector-read-session = Мастер читает номер своего сеанса
vector-beat = Мастер меняет сигнал исправности
vector-read-key = Мастер читает ключ первого ствола
vector-take = Мастер берёт управление
vector-open = Мастер открывает затвор 1 с ключом
vector-read-result = Мастер читает результаты
vector-replay = То же открытие ещё раз: ключ уже другой
vector-stop = Мастер останавливает всё
vector-part = Часть блока не принимается: исключение 3
vector-beyond = Регистра нет: исключение 2

# The Modbus server: what is wrong with hub.toml.
check-servers = Серверов слишком много.
check-servers-remedy = Не больше 64 разделов [[modbus_server]].
check-server-name = `{ $name }` — не имя сервера или клиента Modbus.
check-server-twice-remedy = Имена серверов различны.
check-server-for-none = Сервер { $name } не ответил бы ни одному мастеру: role — "none", и ни одного client.
check-server-for-none-remedy = Добавьте [[modbus_server.client]] или напишите role = "observer".
check-slow-heartbeat = При heartbeat_ms = { $ms } движение кончается позже чем через 500 мс после мастера, а вручную приводы не движутся вовсе: сигналы реже чем раз в 300 мс ничего не двигают.
check-slow-heartbeat-remedy = Укажите heartbeat_ms = { $ms } или меньше либо наводите только командой 4.
check-net = `{ $text }` — не адрес и не сеть.
check-net-remedy = Укажите адрес, 10.0.0.7, или сеть, 10.0.0.0/24.
check-nets = Список слишком длинный.
check-nets-remedy = Не больше 64 записей; для нескольких адресов укажите сеть.
check-listen-name = `{ $host }` — не IP-адрес для приёма подключений.
check-listen-name-remedy = Напишите tcp://127.0.0.1:502, tcp://0.0.0.0:502 вместе с allow, rtu+tcp://… или serial:///dev/ttyS1?baud=19200.
check-allow = { $address } доступен с других машин, а входа по паролю в Modbus нет.
check-allow-remedy = Напишите allow = ["10.0.0.7"] с адресами мастеров или принимайте подключения на 127.0.0.1.
check-allow-on-serial = У мастера последовательной линии нет адреса.
check-allow-on-serial-remedy = Уберите allow и from.
check-server-port = Последовательный порт занят стволом или другой линией.
check-server-port-remedy = Отведите мастеру отдельный порт.
check-server-same-line = Там уже принимает подключения сервер { $name }.
check-server-same-line-remedy = У каждого сервера свой порт; несколько мастеров делят один через [[modbus_server.client]].
check-server-monitor = Ствола { $id } нет.
check-server-monitor-remedy = Укажите имена стволов из этого файла, каждое один раз.
check-server-empty = `monitors` сервера { $name } пуст: его мастерам ничто не доступно, даже Стоп.
check-server-empty-remedy = Укажите имена его стволов или уберите `monitors`: тогда доступны все.
check-server-units = Восемь стволов — одно устройство: последним был бы адрес { $last }.
check-server-units-remedy = Укажите меньший unit или меньше стволов.
check-no-stop = Клиенту { $name } не доступны регистры команд: он не может даже остановить ствол.
check-no-stop-remedy = Пусть его registers включают { $first }–{ $last }; наблюдатели могут там только остановить, закрыть и заблокировать.
check-registers = Регистры кончаются раньше, чем начинаются.
check-registers-remedy = Напишите registers = [первый, последний].

# MQTT: events and states of the connection.
mqtt-not-yet = Ещё не подключено.
mqtt-connected = Брокер MQTT { $name } подключён: { $url }.
mqtt-not-connected = Брокер MQTT { $name } ({ $url }) не подключён: { $why }
mqtt-silent = Клиенты { $client } ({ $from }) молчат: начатые ими движения прекращаются, управление они теряют, если не вернутся.
mqtt-failed = Соединение с брокером не удалось: { $error }.
mqtt-no-answer = Брокер не отвечает в течение { $s } с.
mqtt-closed = Брокер закрыл соединение.
mqtt-sent-away = Брокер прекратил соединение: { $why }.
mqtt-not-authorized = Брокер не принимает этого пользователя с паролем или этот client_id. Проверьте user, password и client_id.
mqtt-old-version = Брокер не работает по MQTT 5.
mqtt-turned-away = Брокер отказал в соединении: { $why }.
mqtt-why-forbidden = он не допускает этого клиента
mqtt-why-busy = он занят или недоступен
mqtt-why-ends = он завершает работу
mqtt-why-silence = он слишком долго ничего не получал от сервера объекта
mqtt-why-taken-over = под тем же именем подключился другой клиент
mqtt-why-limit = превышен один из его пределов (размер, частота, число или время)
mqtt-why-elsewhere = нужно подключаться к другому брокеру
mqtt-why-unsupported = он не принимает таких тем, сохраняемых сообщений или такого качества доставки
mqtt-why-name = он не принимает имени этого клиента
mqtt-why-protocol = он счёл сообщение ошибкой протокола
mqtt-why-unknown = причину он не называет
mqtt-no-subscription = Брокер не разрешает этому пользователю подписку на темы команд под { $prefix }: не дошёл бы даже стоп. Проверьте его список доступа.
mqtt-tls = Ошибка TLS: { $error }.
mqtt-no-authority = Эта машина не доверяет ни одному центру сертификации. Укажите центр брокера в ca.
mqtt-unknown-issuer = Сертификат брокера подписан центром, которому нет доверия. Укажите нужный в ca.
mqtt-other-name = Сертификат брокера выдан не для { $host }. Напишите в url имя из сертификата.
mqtt-not-in-time = Сертификат брокера сейчас не действует. Проверьте его сроки и часы этой машины.
sparkplug-waits = Основного приложения { $host } нет: до его появления ничего не публикуется.
sparkplug-dropped = Брокер MQTT { $name }: значения, которые не удалось отправить, отброшены, с начала работы сервера объекта — { $count }.

# MQTT: why a command is refused, where Modbus has other words.
mqtt-no-command = Такой команды нет, или она не для всех стволов сразу. См. список команд.
mqtt-no-monitor = Ствола с таким обозначением здесь нет. См. обозначения в темах состояний.
mqtt-argument = Аргумента не хватает, он не для этой команды или вне допустимых значений. См. список команд.
mqtt-void = Не отправлено: клиенты молчали, управление потеряно, либо раньше пришёл стоп.
mqtt-role = По hub.toml клиенты этого брокера могут только остановить, закрыть и заблокировать.
mqtt-held = Управление у другого клиента. Запросите его командой ask или дождитесь, пока оно освободится.
mqtt-not-taken = Управление ни у кого. Сначала возьмите его командой take.
mqtt-key = Ключ — не тот, что предлагается сейчас. Прочтите ключ этого ствола и отправьте его один раз.
mqtt-twice = Этот id уже был у другой команды. С каждой командой отправляйте новый id.
mqtt-refused = Ствол отказал; его результат (§2/5) — в status.
mqtt-ticket = Нет ticket, или он старше 3 с. Отправьте последний из опубликованных.
mqtt-retained = Сохраняемое сообщение (retain) ничем не управляет. Отправьте его без этого признака.
mqtt-form = Это не команда: нужен JSON с id и command, без полей не из списка.

# MQTT: what is wrong with hub.toml.
check-brokers = Брокеров слишком много.
check-brokers-remedy = Не больше 8 разделов [[mqtt]].
check-broker-name = `{ $name }` — не имя брокера.
check-broker-twice-remedy = Имена брокеров различны.
check-broker-same = Брокер { $name } — тот же, с тем же client_id или prefix.
check-broker-same-remedy = Оставьте один раздел [[mqtt]] или укажите другие client_id и prefix.
check-broker-url = `{ $text }` — не брокер.
check-broker-url-remedy = Напишите mqtts://broker.site:8883 или mqtt://127.0.0.1:1883.
check-broker-plain = Соединение с { $host } — без TLS: пароль, ticket и ключи, открывающие затворы, можно прочесть по пути.
check-broker-plain-remedy = Напишите mqtts:// и ca или plain = true, если сеть отведена только для этого.
check-client-id = `{ $text }` — не client_id.
check-client-id-remedy = Напишите 1…64 буквы, цифры и знаки без пробелов.
check-two-passwords = Паролей два.
check-two-passwords-remedy = Напишите password или password_file.
check-password-alone = Пароль без пользователя.
check-password-alone-remedy = Напишите user.
check-password-file = { $path }: { $why }
check-password-file-remedy = Укажите путь к файлу, первая строка которого — пароль; относительный путь — от папки этого файла.
check-tls-unused = ca, cert и key — только для mqtts://.
check-tls-unused-remedy = Напишите в url mqtts:// или уберите их.
check-cert-and-key = Сертификат и его ключ указывают вместе.
check-cert-and-key-remedy = Напишите cert и key.
check-prefix = { $key } = `{ $text }` — не начало темы.
check-prefix-remedy = Напишите 1…64 знака без + # $ и без / в начале, в конце и двух подряд.
check-broker-monitors = Стволов для одного брокера слишком много.
check-broker-monitors-remedy = Не больше 256 стволов.
check-sparkplug-name = { $key } = `{ $text }` — не имя Sparkplug.
check-sparkplug-name-remedy = Напишите 1…64 знака без / + #; группы STATE не бывает.
check-sparkplug-alone = { $key } — не для брокера с sparkplug: темы у него — этого формата.
check-sparkplug-alone-remedy = Уберите или напишите ещё один раздел [[mqtt]] для наших тем.
check-topic-taken = Тема ствола { $id } — одна из собственных тем сервера объекта.
check-topic-taken-remedy = Дайте стволу другое имя или не указывайте его в `monitors`.

# Серверы OPC UA: их состояние.
opcua-not-yet = Он запускается.
opcua-listening = Сервер OPC UA { $name } принимает подключения: { $url }.
opcua-not-listening = Сервер OPC UA { $name } не принимает подключения: { $why }
opcua-failed = Сбой: { $error }.
opcua-ended = Он остановился.
opcua-no-certificate = Его сертификат или ключ не удаётся прочитать или создать. Проверьте cert и key либо папку сертификатов.
opcua-silent = { $client } ({ $from }) молчит по OPC UA: начатые им движения прекращаются, управление он теряет, если не вернётся.

# OPC UA: почему вызов отклонён — там, где у Modbus и MQTT другие слова.
opcua-no-method = Такого метода нет, либо его нельзя вызвать сразу для всех стволов.
opcua-argument = Аргумента нет, или он вне диапазона. Смотрите список методов.
opcua-void = Не отправлено: клиент молчал, управление потеряно, либо раньше пришёл стоп.
opcua-role = Этот пользователь может здесь только останавливать, закрывать и блокировать: так задано в hub.toml или ролью.
opcua-held = Управление у другого клиента. Запросите его методом Ask или дождитесь, пока оно освободится.
opcua-not-taken = Управления ни у кого нет. Сначала возьмите его методом Take.
opcua-key = Ключ не тот, что предлагается сейчас. Получите его методом GetKey и отправьте один раз.
opcua-refused = Ствол отказал; его результат (§2/5) — в Status.
opcua-ticket = Билета нет, или он старше 3 с. Отправьте тот, который последним вернул Alive.

# OPC UA: состояния условий.
opcua-enabled = Включено
opcua-active = Активна
opcua-inactive = Неактивна
opcua-acked = Квитирована
opcua-unacked = Не квитирована
opcua-shelved = Отложена
opcua-unshelved = Не отложена

# OPC UA: что не так в hub.toml.
check-opcuas = Серверов OPC UA слишком много.
check-opcuas-remedy = Напишите не больше 4 [[opcua]].
check-opcua-name = `{ $name }` — не имя сервера OPC UA.
check-opcua-listen-remedy = Напишите АДРЕС:ПОРТ, например 127.0.0.1:4840 или 0.0.0.0:4840 вместе с allow и host.
check-opcua-allow = { $address } доступен с других машин.
check-opcua-allow-remedy = Напишите allow = ["10.0.0.7"] с адресами клиентов или принимайте подключения на 127.0.0.1.
check-opcua-plain = К { $address } можно было бы подключиться с других машин без защиты.
check-opcua-plain-remedy = Уберите plain: сообщения клиентов подписываются и шифруются. Без защиты — только на 127.0.0.1.
check-opcua-anonymous = Клиенты без пользователя могли бы управлять стволами с других машин через { $address }.
check-opcua-anonymous-remedy = Напишите anonymous = "observer" или уберите его; пользователи сервера входят по паролю.
check-opcua-host = `{ $text }` — не узел.
check-opcua-no-host = Из { $address } не видно, под каким именем или адресом клиенты обращаются к серверу.
check-opcua-host-remedy = Напишите host = "hub.site" или host = "10.0.0.5".
check-opcua-monitors = Стволов для одного сервера OPC UA слишком много.
