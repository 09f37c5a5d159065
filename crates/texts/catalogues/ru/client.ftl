## What the client says: errors, refusals, what to do about them, the diagnosis of a link.

# error.rs: why a request failed.
refused = { $request } { $to }: { $by } отвечает { $status }. { $why } { $remedy }
no-answer-but-stray = { $request } { $to }: нет ответа от { $endpoint }, попыток: { $tries }. Пришёл ответ на { $stray }, которого не запрашивали: соединением пользуется другая программа или программа ствола отступает от протокола.
no-answer = { $request } { $to }: нет ответа от { $endpoint }, попыток: { $tries }. Проверьте питание, кабель, адрес (addr=), а на последовательной линии и скорость (baud=).
absent = На { $endpoint } никто не отвечает, проб: { $tries }. Проверьте питание, кабель, адрес (addr=), а на последовательной линии и скорость (baud=).
not-probed = На { $endpoint } ничего не отправлено, так как { $cause }.
outcome-unknown = { $request } { $to }: отправлено на { $endpoint }, но { $cause }. Запрос мог быть исполнен. { $check }
not-sent = { $request } { $to }: не отправлено, так как { $cause }. Ничего не исполнено: повторите, если это всё ещё нужно.
cannot-switch-direction = { $endpoint }: драйвер этого порта не умеет переключать направление RS-485 сигналом RTS ({ $source }). Уберите rs485=, если адаптер делает это сам, как большинство на USB.
no-connection = Нет соединения с { $endpoint }: { $source }. Проверьте, что ствол включён и что узел, порт или устройство указаны верно.
breaks-protocol = { $request } { $from }: ствол ответил, но не так, как требует протокол: { $what }. Программа ствола отступает от протокола: запишите и сообщите.
too-long = { $request } { $to }: больше, чем вмещает запрос (255 байт данных, 63 значения). Отправьте меньше значений.
not-a-read = { $request } { $to } что-то изменяет, поэтому его нельзя повторять постоянно. Подпишитесь на запрос чтения.
address-impossible = { $endpoint }: { $address } — не адрес другого устройства на этой линии. У стволов 1…127; голые записи (framing=records) ведут только к одному стволу.
needs-stream = Для sim: нужен имитатор в этом же процессе. Передайте клиенту его поток или запустите `lafet sim` и подключитесь к напечатанному адресу.
closed = Клиент завершил работу. Создайте новый.

# Why nothing was sent, or what came instead of an answer: a clause in the sentences above.
cause-silence = ответ не пришёл
cause-odd-answer = ответ { $from } не соответствует протоколу: { $what }
cause-no-connection = нет соединения ({ $source })
cause-superseded = его опередил запрос { $by }
cause-queue-full = слишком много запросов в очереди
cause-expired = его время вышло раньше, чем подошла очередь
cause-earlier-failed = не удался другой запрос пакета
cause-check-missing = ствол отвечает только на кадры с CRC-16 (укажите check=auto)
cause-no-controller = на магистрали нет контроллера, который дал бы доступ (укажите role=direct)
cause-not-granted = контроллер магистрали не даёт доступа этому адресу (ищет ли он src=, и не занят ли этот адрес другим?)
cause-unreadable = на линии идут байты, которые не складываются в кадры: обмен на другой скорости или помехи (правильно ли указано baud=? с insist=1 запросы всё же отправляются)
cause-controller-present = на магистрали есть контроллер (укажите role=active и свой src=)

# deviation.rs: how an answer breaks the protocol; a clause without a full stop.
odd-shape = неверный размер или вид данных ({ $error })
odd-no-data = сообщает об успехе, но данных в нём нет
odd-status = кода возврата { $status } в протоколе нет
odd-other-parameter = запрошен параметр { $asked }, ответ относится к { $answered }
odd-other-request = это ответ на { $answered }
odd-other-subsystem = запрошена подсистема { $asked }, а { $answered } не может отвечать за неё
odd-no-subsystem = его отправитель, { $answered }, — не подсистема ствола
odd-count = записей в нём { $answered }, запросов было { $asked }

# port_error.rs: why a serial port cannot be opened.
port-in-use = Порт { $port } занят { $by }. Закройте её или укажите shared=1 в URL обеих программ: тогда каждая может терять ответы из-за другой.
another-program = другой программой
program-with-id = программой { $program } ({ $pid })
port-not-permitted = Нет прав на открытие { $port }. Вступите в группу { $group } (`sudo usermod -aG { $group } $USER`) и войдите в систему заново.
port-of-owner = Нет прав на открытие { $port }: их может дать владелец.
port-missing = Порта { $port } нет. Проверьте, подключён ли адаптер; `lafet ports` покажет имеющиеся порты.
port-without-door = Порт { $port } не прослушивается: Stop другой программы не смог бы его запросить ({ $error }). У системы не осталось сокета для этой программы: закройте другие или увеличьте предел открытых файлов (`ulimit -n`).
port-other-adapter = { $port } — теперь другой адаптер: { $now } вместо { $was }. В него ничего не передаётся: за ним может быть другой ствол. Подключите прежний адаптер; путь из /dev/serial/by-id указывает адаптер, а не гнездо (`lafet ports`).
port-not-serial = { $port } — не последовательный порт, или за ним нет оборудования. `lafet ports` покажет имеющиеся порты.

# os_text.rs: errors of the system. In English the system words them itself.
os-not-found = нет такого файла, устройства или узла
os-not-permitted = нет прав доступа
os-refused = в соединении отказано
os-reset = соединение сброшено другой стороной
os-aborted = соединение прервано
os-not-connected = нет соединения
os-host-unreachable = узел недостижим
os-network-unreachable = сеть недостижима
os-network-down = сеть отключена
os-address-in-use = адрес уже занят
os-address-not-here = такого адреса на этом компьютере нет
os-broken-pipe = другая сторона закрыла соединение
os-exists = уже существует
os-timed-out = время ожидания вышло
os-unexpected-end = данные кончились раньше, чем ожидалось
os-disk-full = на диске нет места
os-read-only = файловая система только для чтения
os-is-folder = это папка, а не файл
os-not-folder = это не папка
os-busy = устройство занято
os-invalid = недопустимое значение
os-too-large = файл больше, чем позволено
os-quota = исчерпана дисковая квота
os-no-utf8 = это не текст UTF-8
os-host-unknown = имя узла не найдено: проверьте, верно ли оно написано и доступен ли сервер имён, или укажите адрес ({ $error })
os-other = ошибка системы: { $error }
os-numbered = { $what } (ошибка системы { $number })

# url_error.rs: errors of a monitor's URL, and the values of its options.
url-syntax = `{ $url }` — не адрес URL: { $reason }. Напишите, например, { $example }.
url-no-host = узел не указан
url-host-sign = недопустимый знак в имени узла
url-ipv4 = неверный адрес IPv4
url-ipv6 = неверный адрес IPv6
url-no-scheme = нет схемы, например tcp://
url-scheme = `{ $url }`: по `{ $scheme }:` ствол недоступен. Используйте tcp://, udp://, serial:// или sim:, например { $example }.
url-nowhere = `{ $url }`: не указано, куда подключаться. Пример: { $example }.
url-part = `{ $url }`: часть `{ $part }` здесь не имеет смысла. Уберите её.
url-option = Параметра `{ $key }` здесь нет. Возможные: { $known }.
url-twice = Параметр `{ $key }` указан дважды. Оставьте один.
url-value = `{ $key }={ $value }`: допустимо: { $allowed }.
allowed-monitor-address = адрес ствола, 1…127
allowed-source-address = адрес контроллера 128 или пульта, 129…254
allowed-baud = скорость линии, 300…4000000 (обычно 19200)
allowed-framing = link или records
allowed-port = число, 1…65535
allowed-rs485 = off, rts или rts-low
allowed-echo = off, strip или verify
allowed-delay = время в миллисекундах, 0…1000
allowed-check = crc16, auto или crc32c
allowed-role = direct или active
allowed-console-address = адрес пульта, 129…254, вместе с role=active
allowed-late = время в целых секундах, 0…60
allowed-yes = 0 или 1
allowed-switch = on или off
allowed-with-rs485 = только вместе с rs485=rts или rs485=rts-low

# backup/file.rs: errors in a file of parameters.
file-no-toml = это не TOML, строка { $line }: { $what }
file-format = это не файл `lafet param backup` либо файл более новой lafet: нет `format = { $format }`
file-cut = это только часть файла: нет последней строки `{ $end }`. Возьмите полную копию
file-unknown = строка { $line }: { $name }: такого параметра нет в словаре
file-count = строка { $line }: { $title }: ожидаются целые числа, от { $min } до { $max }
file-range = строка { $line }: { $title }: допустимо { $allowed }
file-read-only = строка { $line }: { $title }: не устанавливается; удалите его из файла

# parse_error_text.rs: what is wrong in the text of a request.
parse-error = позиция { $column }: { $expected }
parse-error-meant = позиция { $column }: { $expected }; может быть, `{ $name }`?
expected-request = ожидается запрос (0x и две цифры либо одно из: { $names })
expected-subsystem = ожидается подсистема (0x и две цифры либо одна из: { $names })
expected-parameter = ожидается параметр { $subsystem } (0x и четыре цифры, @ЛюбоеИмя)
expected-parameter-of = ожидается параметр { $subsystem } (0x и четыре цифры, @ЛюбоеИмя либо один из: { $names })
expected-word = ожидается { $words }
or = { $one } или { $other }
expected-number = ожидается { $what }: число от { $min } до { $max }
expected-numbers = ожидается { $what }: чисел через запятую — { $count }
missing = не хватает: { $what }
given-twice = задано дважды
not-together = { $one } и { $other } относятся к разным вариантам запроса
expected-hex = ожидаются байты в шестнадцатеричном виде, например `de ad be`
expected-end = здесь запрос должен закончиться
expected-fewer-data = слишком много данных: запрос вмещает не более 255 байт
request-wrong = запрос записан неверно

# What a number of a request means.
number-destination = точка назначения
number-start-horizontal = начало сектора по горизонтали
number-end-horizontal = конец сектора по горизонтали
number-start-vertical = начало сектора по вертикали
number-end-vertical = конец сектора по вертикали
number-value = значение
number-key = ключ
number-program = номер программы
number-nozzle = положение насадка
number-step = шаг
number-distance = расстояние
number-dwell = выдержка
number-horizontal = горизонталь
number-vertical = вертикаль
number-correction = поправка
number-corrections = поправки
number-trajectory = номер траектории
number-first = первый номер
number-count = количество
number-analyse = признак анализа
number-centre = центр по горизонтали и вертикали
number-sector = ширина и высота сектора
number-point = точка: горизонталь, вертикаль, расстояние, выдержка
number-distance-or-corrections = distance= или corrections=
number-point-or-stored = point= или stored=

# outcome_check.rs: how to check whether a request without an answer was executed.
check-move = Это покажет GetStatus привода: установлен Move или изменилось положение.
check-stop = Сразу пошлите ещё раз; GetStatus All покажет, когда движение прекратилось.
check-open = Это покажет GetStatus затвора: Opening или Open. При сомнении пошлите Close.
check-close = Сразу пошлите ещё раз; GetStatus затвора покажет Closing или Closed.
check-deployer = Это покажет GetStatus Deployer: Deploying, Deployed, Wrapping или Wrapped.
check-parameter = GetParam того же параметра покажет его нынешнее значение.
check-correction-table = Таблицу нельзя прочитать обратно. Пошлите те же поправки ещё раз: это безвредно.
check-justify = Это покажет GetStatus Detector: Justifying, Justified или DeviceFault.
check-program = Это покажет GetStatus Control: Quench или Trajectory. При сомнении пошлите Stop Control.
check-seek = Это покажет GetStatus Detector: Searching, Found или Canceled.
check-limits = Это покажет GetStatus Motors: при выключенных пределах установлен Limitless.
check-lockout = Это покажет GetStatus General: при блокировке установлен LockedOut.
check-restart = Это покажет GetStatus All: Restarting, либо всё как после включения питания.
check-clean-flash = Это покажет GetStatus General: при пустой памяти установлен ConfigInvalid.
check-other = Прочитайте состояние, прежде чем повторять.

# refusal.rs: why a request was refused, and what to do.
limits-state-unknown = Такого состояния пределов нет.
limits-state-remedy = Пошлите 0 (off), 1 (on) или 2 (reject).
deploy-first = Разверните ствол и дождитесь Deployed в GetStatus Deployer.
stop-detector = Дождитесь снятия Searching и Justifying либо пошлите Stop Detector.
stop-control = Дождитесь конца программы либо пошлите Stop Control.
close-valve = Закройте затвор и дождитесь Closed. Если он уже Closed, прочитайте InputFaults подсистемы General: бит 0 означает, что вода всё же течёт; перекройте магистраль вручную.
stop-all = Пошлите Stop тому, кто отказал, либо Stop All: он не отклоняется никогда.
read-flags = Прочитайте состояние подсистемы: её флаги называют неисправность.
locked-out = Включена аварийная блокировка: исполняются только чтение и SetParam.
locked-out-remedy = Выясните, кто и зачем включил блокировку; затем снимите её (Lockout off).
locked-by-update = Блокировку держит обновление: образ на пробе или назначение ещё не отменено.
locked-by-update-remedy = Посмотрите `lafet update --state`. Доведите обновление до конца (та же команда `lafet update` продолжит) или подождите возврата к старой версии, 180 с после пуска; затем снимите блокировку (Lockout off).
deployer-moves = Идёт развёртывание или сворачивание: его прекращает только Stop Deployer или Stop All.
not-deployed = Ствол не развёрнут: он свёрнут, движется или стоит между положениями.
program-or-alignment-runs = Выполняется программа тушения или юстировка либо выключены пределы.
program-or-alignment-remedy = Пошлите Stop Control или Stop Detector; включите пределы.
search-runs = Идёт поиск очага: его прекращает только Stop Detector или Stop All.
search-or-alignment-runs = Идёт поиск очага или юстировка.
program-without-limits = Пределы выключены: программа могла бы увести ствол куда угодно.
limits-on = Включите пределы. Если положение привода неизвестно (биты 8–10 InputFaults подсистемы General), сначала подведите его к концу, заданному параметром Homing.
program-only-stopped = Выполняется программа тушения: её прекращает только Stop Control или Stop All.
program-runs = Выполняется программа тушения.
water-in-folding-barrel = Затвор не закрыт либо вода течёт: сворачиваемый ствол она разрушит.
water-before-detector = Затвор не закрыт либо вода течёт: извещатель смотрел бы в воду.
water-under-folding-barrel = Затвор не закрыт либо вода течёт: под водой ствол сворачивать нельзя.
valve-blocked = Затвор заблокирован аппаратно (Blocked): его можно закрыть, но не открыть.
valve-blocked-remedy = Переведите блок затвора в дистанционный режим, выведите маховик, проверьте цепь блокировки; возможно, с затвором работают люди. Когда Blocked снимется, Open снова принимается.
not-homed = Привод ещё не доведён до концевого выключателя: его положение неизвестно, а с ним и пределы.
barrel-not-homed = Horizontal или Vertical ещё не доведён до концевого выключателя: где ствол сворачивать, неизвестно.
home-it = Подведите привод к концу, заданному его параметром Homing: концевой выключатель там остановит его. Какие приводы не доведены, показывают биты 8–10 InputFaults подсистемы General.
water-flows = Затвор не закрыт либо вода течёт.
locked-out-or-weak = Включена аварийная блокировка либо напряжение питания вне диапазона: тогда не начинается ни движение, ни подача воды, ни стирание.
locked-out-or-weak-remedy = Что именно, показывает GetStatus General. LockedOut: выясните, кто и зачем включил блокировку, и снимите её (Lockout off). BadPower: проверьте питание.
supply-weak = Напряжение питания вне диапазона (BadPower): не начинается ни движение, ни подача воды, ни стирание; Stop, Close и Lockout исполняются.
supply-remedy = Сравните main_voltage подсистемы General с показаниями прибора на клеммах и с MainVoltageMin и MainVoltageMax; проверьте источник, батарею и кабель. Когда BadPower снимется, запрос снова принимается.
button-held = На кнопочном посту нажата кнопка этого привода: у неё приоритет над запросами.
release-button = Дождитесь, пока её отпустят; какая кнопка нажата, показывает состояние Buttons и ExtButtons.
barrel-not-homed-or-water = Horizontal или Vertical ещё не доведён до концевого выключателя либо течёт вода, а затвора нет.
barrel-not-homed-or-water-remedy = Прочитайте InputFaults подсистемы General: биты 8–10 показывают, какие приводы подвести к концу, заданному параметром Homing; если течёт вода, перекройте магистраль вручную.
deployer-not-free = Ствол в дежурном положении либо переходит из одного положения в другое: Move привода Deployer принимается в рабочем положении или при остановке между ними.
deployer-not-free-remedy = Разверните ствол либо дождитесь конца движения.
water-without-valve = Течёт вода, а затвора, который её перекрыл бы, у ствола нет.
close-main = Перекройте магистраль вручную; если вода не течёт, проверьте расходомер.
search-goes-on = Идёт поиск очага (Searching).
alignment-goes-on = Идёт юстировка (Justifying).
alignment-runs = Идёт юстировка: её прекращает только Stop Detector или Stop All.
search-or-alignment-only-stopped = Идёт поиск очага или юстировка: их прекращает только Stop Detector или Stop All.
search-or-no-limits = Идёт поиск очага либо пределы выключены.
search-or-no-limits-remedy = Пошлите Stop Detector; включите пределы.
open-under-folding = Затвор не закрыт: вода разрушит сворачиваемый ствол.
open-before-detector = Затвор не закрыт: извещатель смотрел бы в воду.
valve-not-closed = Затвор не закрыт.
flows-though-closed = Вода течёт, хотя затвор закрыт, либо неисправен его датчик (CloseSensorFault): закрытым он не считается.
look-for-water = Посмотрите, течёт ли вода: если течёт, перекройте магистраль вручную; если нет, проверьте датчик закрытого положения и расходомер.
close-and-wait = Закройте затвор и дождитесь его состояния Closed.
subsystem-faulty = Подсистема неисправна либо остановлена в эту сторону по току.
limits-not-received = Удалённый блок ещё не получил новые пределы.
drive-moves = Привод движется: предел и ноль берутся там, где он стоит.
monitor-restarts = Ствол перезапускается: он отвечает только на чтение.
repeat-in-a-second = Повторите запрос через секунду.
restart-for-all-only = Restart принимается только для All: одну подсистему перезапустить нельзя.
restart-all = Пошлите Restart All.
not-for-broadcast = Ни одна подсистема не принимает этот запрос широковещательно.
name-subsystem = Укажите нужную подсистему.
request-not-supported = Ствол вообще не знает такого запроса.
request-not-supported-remedy = Возможно, его программа старше этого запроса: выясните, что она умеет.
request-not-for-subsystem = Для этой подсистемы такой запрос не предусмотрен.
request-not-for-subsystem-remedy = Пошлите его адресату, названному в его разделе протокола.
parameter-count = У параметра другое количество значений.
table-empty = В таблице нет ни одного значения.
quench-form = Данные не подходят ни под один из трёх вариантов StartQuench.
points-count = Число точек не соответствует объёму данных.
correct-count = Исправьте количество значений.
trajectory-empty = Записанная траектория пуста.
trajectory-empty-remedy = Сначала запишите её либо возьмите другую.
parameter-unknown = У подсистемы нет параметра с таким именем.
parameter-unknown-remedy = Проверьте имя буква в букву; у другой версии могут быть другие параметры.
sector-outside-limits = Сектор не целиком внутри пределов (BadSector) либо analyse не 0 и не 1.
sector-inside-limits = Задайте сектор внутри пределов Horizontal и Vertical.
quench-sector-outside-limits = Сектор целиком вне пределов либо одно из его чисел недопустимо.
quench-sector-remedy = Задайте сектор, хотя бы частью лежащий внутри пределов.
trajectory-out-of-range = Точка, признак или номер траектории вне допустимого.
trajectory-numbers = Номера записанных траекторий — от 0 до 7.
limits-crossed = С принятыми пределами нижний оказался бы не ниже верхнего.
limits-crossed-remedy = Примите другой предел заново либо отбросьте оба (SwitchLimits reject).
table-too-long = В таблице 256 значений, не больше.
table-too-long-remedy = Начните раньше либо пошлите меньше.
lockout-key = Ключ не из двух ключей Lockout.
lockout-key-remedy = Пошлите 0x2FFA (включить) или 0x7353 (снять).
parameter-out-of-range = Значение вне диапазона параметра.
parameter-range = Посмотрите диапазон параметра.
drive-parameter-out-of-range = Значение вне диапазона; либо пределы выключены, и тогда предел и ноль принимают только текущее положение.
drive-parameter-remedy = Посмотрите диапазон параметра; включите пределы либо задайте предел по текущему положению.
status-unknown = Протокол не знает такого статуса.
status-unknown-remedy = Сообщите о нём.

# teach.rs: ends of a drive's travel, in a sentence about its limit.
side-left = левый
side-right = правый
side-up = верхний
side-down = нижний
side-narrow = самый узкий
side-wide = самый широкий

# doctor/examine.rs: what the diagnosis is doing.
doing-open = открываю линию
doing-listen = слушаю
doing-wait-for-access = жду доступа
doing-listen-at-speeds = слушаю на других скоростях
doing-probe = вызываю ствол
doing-ask = спрашиваю
doing-addresses = пробую другие адреса
doing-speeds = пробую другие скорости

# doctor/texts.rs: what was observed.
seen-well = Ствол отвечает{ $exchange }.
seen-no-link = { $link } использовать нельзя: { $error }.
seen-nothing = Линия открыта, но не пришло ни одного байта: прослушивание { $listened_s } с, проб по адресу { $monitor }: { $probes }, пробы по всем остальным адресам.
seen-echo = Кадров, вернувшихся точно такими, как отправлены: { $frames }.
seen-no-echo = URL обещает эхо (echo=), но его нет.
seen-other-speed = На скорости из URL кадры не читаются{ $sample }; на { $baud } бод — читаются.
seen-wrong-speed = В ответ на пробы приходят байты ({ $bytes }), но не кадры{ $sample }; без проб линия молчит.
seen-noise = { $silent }Испорченных кадров: { $broken }, байт вне кадров: { $stray_bytes }{ $unasked }{ $exchange }.{ $held_back }
noise-silent = Ствол не отвечает.{ " " }
noise-unasked = ; байт, пришедших без запроса: { $bytes }
seen-loss = Ответов на пробы: { $answered } из { $probes }{ $exchange }; больше ничего не слышно.
seen-unanswered = Ответов на пробы: { $answered } из { $probes }, но ни на один из запросов ({ $sent }) ответа нет.
seen-other-speakers = На линии передают другие устройства: { $who }. Принято кадров: { $frames }.{ $held_back }
nothing-sent = {" "}Поэтому запросы не отправлялись (--insist отправит).
seen-address-taken = Слышны кадры с нашего адреса { $address } или на него, которых мы не посылали и не ждали.
seen-odd-answers = Ствол отвечает на GetStatus General, но не по протоколу: { $odd }.
odd-answers = ответов { $odd } из { $answered }{ $records }
odd-without-records = ; первый — без записей
seen-no-controller = В URL указано role=active, но контроллера не слышно.
seen-no-access = Контроллер слышен, но доступа нашему адресу { $address } не даёт.
seen-monitor-silent = Контроллер даёт доступ, но адрес { $monitor } не отвечает.
seen-wrong-address = Адрес { $monitor } молчит, проб: { $probes }; отвечают: { $others }.
seen-two-with-one-address = На одну пробу по адресу { $monitor } пришло два ответа.
seen-crc32c-only = На кадры с обычной CRC-16 ответа нет, на кадр с CRC-32C — есть.
seen-records-answered = На канальные кадры ответа нет, на голую запись — есть.
seen-frames-answered = На голые записи ответа нет, на канальный кадр — есть.
seen-other-protocol = Устройство работает по другому протоколу. Получено: `{ $text }`
exchange-result = ; отвечено запросов: { $answered } из { $sent }, в среднем за { $mean } мс, не дольше { $max } мс
first-bytes = {" "}(первые байты: { $bytes })
controller-at = контроллер магистрали, адрес { $address }
console-at = пульт, адрес { $address }
device-at = адрес { $address }

# What to do about it.
do-nothing = Делать ничего не нужно.
do-check-port = Проверьте имя порта, подключён ли адаптер, есть ли права на него (группа dialout) и не занят ли он другой программой.
do-check-network = Проверьте узел и порт, включён ли ствол или сервер последовательных портов, сетевой кабель и межсетевой экран; `lafet scan УЗЕЛ` ищет открытые порты.
do-check-power-serial = Проверьте питание ствола, не перепутаны ли A и B, общий провод, переключает ли адаптер направление (rs485=rts, если сам не умеет).
do-check-power-network = Проверьте питание ствола и его провода за сервером последовательных портов; порт UDP молчит и тогда, когда его никто не слушает.
do-echo-known = Делать ничего не нужно: это указано в URL.
do-echo-serial = Работе lafet оно не мешает. С echo=strip в URL эхо отбрасывается, с echo=verify по отличиям видны ещё и столкновения. Либо отключите приёмник адаптера на время передачи.
do-echo-server = Сервер последовательных портов возвращает переданное: отключите в нём эхо (двухпроводный режим RS-485).
do-no-echo = Уберите echo= из URL: без эха столкновения так не найти.
do-set-baud = Впишите в URL baud={ $baud }.
do-check-speed-serial = Проверьте baud= (встречаются 19200, 57600 и 115200), 8N1 и не перепутаны ли A и B.
do-check-speed-network = Установите в сервере последовательных портов скорость ствола (встречаются 19200, 57600 и 115200), 8N1.
do-noise = Проверьте согласующие резисторы (120 Ом только на двух концах), смещение, общий провод, экран и не идёт ли кабель рядом с двигателями; попробуйте меньшую скорость. Check = 1 у ExternalConn оставляет только кадры с CRC-32C.
do-loss = Ответы опаздывают или теряются: увеличьте --timeout, проверьте радио или сеть на пути и не пользуется ли линией кто-то ещё.
do-unanswered = По этому адресу есть устройство, но на запросы оно не отвечает: убедитесь, что это лафетный ствол, перезапустите его и проверьте то, что стоит на пути (радио, сервер последовательных портов): возможно, оно пропускает только короткие кадры или искажает длинные. `lafet record` покажет, что приходит.
do-two-programs = Две программы, передающие без очереди, мешают друг другу: завершите другую или поставьте контроллер магистрали.
do-use-controller = На линии есть контроллер магистрали: без его разрешения передавать нельзя. Работайте со стволом через контроллер либо отключите его на время прямой работы.
do-two-controllers = На одной линии два контроллера магистрали: отключите один из них или дайте этой программе адрес пульта (src=129…254).
do-own-address = Дайте этой программе свой адрес (src=129…254) или завершите другую.
do-set-address = Впишите в URL addr={ $one }.
do-choose-address = Впишите в URL адрес нужного ствола (addr=).
do-odd-answers = Проверьте программу ствола и её версию: `lafet conform` покажет, каких положений протокола она не соблюдает. Полагаться на её ответы нельзя.
do-start-controller = Запустите контроллер (`lafet bus`) или уберите role=active из URL, если на этой линии его нет.
do-no-access = Проверьте, что контроллер ищет этот адрес (--addresses) и что его нет у другого устройства (src= в URL).
do-monitor-silent = Проверьте питание и кабель ствола и addr= в URL; `lafet bus who` покажет, какие устройства есть на магистрали.
do-change-address = Дайте одному из них другой адрес: отключите второй, затем `lafet param set general Address N`, `lafet restart`.
do-crc32c = Так отвечают стволы lafet при Check = 1. Клиентам без CRC-32C нужен Check = 0: `lafet param set externalconn Check 0`.
do-records = Впишите в URL framing=records.
do-link-frames = Уберите из URL framing=records.
do-other-service = Проверьте порт: это какая-то другая служба.

# Tuning of a drive: why it ended.
tune-valve-open = { $valve } не закрыт. Сначала закройте его: привод настраивают без воды.
tune-water = Вода течёт, хотя все затворы сообщают, что закрыты. Перекройте подачу и проверьте затворы.
tune-no-position = { $drive } не сообщает своего положения.
tune-limits-off = Пределы { $drive } выключены, или он ещё не доведён до концевого выключателя: движение продолжалось бы до конца хода. Сначала включите пределы.
tune-too-little-room = Пределы { $drive } оставляют меньше { $room }: для настройки мало.
tune-stopped = { $drive } остановился в { $at }.
tune-no-value = { $drive } не останавливается в заданном положении ни при каком значении. Проверьте люфт редуктора и трение; параметры прежние.
tune-mm = { $distance } мм
tune-degrees = { $distance }°

# update/image.rs: why a file is no image that could be sent.
image-foreign = Это не образ: файл не начинается с LAFETIMG. Образ из программы делает `lafet image sign`.
image-too-large = В файле { $there } байт, а образ не длиннее { $most } МиБ. Не другой ли это файл?
image-cut = Файл неполный: есть { $there } байт из { $wanted }. Скопируйте его заново целиком.
image-longer = За концом образа есть что-то ещё: в файле { $there } байт, в образе { $wanted }. Скопируйте образ заново, без лишнего.
image-format = Формат образа { $format }, а этой версии lafet известен формат { $known }. Возьмите ту версию lafet, которой он сделан, или более новую.
image-unit = Байт 12: размер данных { $size }; он должен быть кратен 8 и не равен 0. Файл повреждён: скопируйте его заново.
image-board = Байт 24: это не имя платы (от 1 до 16 видимых знаков ASCII, за ними нули). Файл повреждён: скопируйте его заново.
image-slot = Байт 40: область { $slot }; бывают 1 (A), 2 (B) и 0 (любая). Файл повреждён: скопируйте его заново.
image-key = Байт 41: ключ { $key }; бывают от 0 до 15. Файл повреждён: скопируйте его заново.
image-revokes-itself = Байт 42: образ отозвал бы ключ { $key }, которым подписан. Подпишите его другим ключом.
image-layouts = Байт 44: образ читает раскладки параметров начиная с { $oldest }, а пишет { $newest }. Файл повреждён: скопируйте его заново или подпишите ещё раз.
image-reserved = Байты 10–11 или 48–63 — не нули. Файл повреждён или сделан более новой версией lafet: скопируйте его заново или возьмите ту версию.
image-digest = Данные не те, что были подписаны: их SHA-256 не совпадает с байтами 64–95. Файл повреждён: скопируйте его заново.

# update/error.rs: why an update has ended.
update-not-supported = Ствол отвечает на Update: { $status } — по линии он не обновляется. Его программа должна быть собрана с обновлением; иначе её обновляют на плате.
update-deaf = Новая программа отвечает на Update: { $status } — она собрана без обновления, поэтому по линии её не подтвердить и не вернуть старую, и она не знает, что она на пробе. Не снимайте аварийную блокировку. Выключите и включите питание ствола: запустится старая программа, с блокировкой.
update-no-image = Писать можно только в область { $slot }, потому что работает другая, а среди образов нет подходящего. Укажите и образ для области { $slot }.
update-already-running = Версия { $version } уже работает и подтверждена. Ничего не изменено.
update-not-ready = Состояние ствола не позволяет его обновлять. { $why } Затем повторите обновление: оно продолжится с того же места.
update-not-locked-out = Аварийная блокировка не включена: включите её (`lafet lockout on`).
update-not-stowed = Ствол не в дежурном положении: сверните его (`lafet wrap`) и дождитесь, пока он свернётся.
update-valve-open = { $valve } не закрыт: закройте его (`lafet close`) и дождитесь, пока он закроется.
update-drive-moves = { $drive } движется: дождитесь покоя или остановите его.
update-bad-supply = Напряжение питания вне диапазона (BadPower): проверьте питание.
update-waits-for-restart = Его параметр { $param } подействует при следующем запуске, а обновление — это запуск: снимите аварийную блокировку, перезапустите ствол (`lafet restart`), убедитесь, что он там и такой, как нужно, и снова заблокируйте его.
update-not-ready-hidden = Почему, из состояния не видно. Возможно, блокировка ещё не записана: включите её ещё раз (`lafet lockout on`). Или привод вращался сам и отключён: осмотрите приводы.
update-refused = Ствол не выполнил указание: { $why }
update-refused-unknown = Ствол не выполнил указание по причине { $number }, которой эта версия lafet не знает. Возьмите более новую версию lafet.
update-reason-no-image = присланное — не образ. Повреждён файл, или искажает линия: повторите обновление.
update-reason-format = формат образа ему неизвестен. Подпишите образ той версией lafet, которая подходит к программе ствола.
update-reason-field = в заголовке значение, которого не бывает. Подпишите образ ещё раз.
update-reason-board = образ для другой платы. Возьмите образ для этой (плату показывает `lafet image show`).
update-reason-place = образ собран для работающей области. Возьмите образ для другой.
update-reason-size = образ пуст, не помещается в область или не кратен 8 байтам. Соберите программу поменьше или подпишите её ещё раз.
update-reason-unknown-key = ключ образа стволу неизвестен. Подпишите образ ключом из списка этого ствола.
update-reason-revoked-key = ключ образа отозван. Подпишите образ другим ключом.
update-reason-revokes-itself = образ отозвал бы собственный ключ. Подпишите его другим ключом.
update-reason-signature = подпись не соответствует ключу. Подписать образ для этой платы может только её изготовитель.
update-reason-not-newer = образ не новее подтверждённого последним. Подпишите его с большей версией; или держите нажатой кнопку на плате, пока обновление начинается: она разрешает более старую версию.
update-reason-layout = образ не читает параметры в том виде, в каком они записаны. Возьмите версию, которая читает.
update-reason-nothing-started = обновление не начато: возможно, ствол перезапустился. Повторите обновление.
update-reason-misplaced = пришли данные не для того места, которого он ждёт. Не обновляет ли его и другая программа? Повторите обновление.
update-reason-incomplete = данные неполны. Повторите обновление: оно продолжится с того же места.
update-reason-digest = данные у него не те, что были подписаны, хотя файл цел. Повторите обновление; если случится снова, неисправна флеш-память.
update-reason-not-verified = образ не проверен. Повторите обновление.
update-reason-trial-first = на пробе уже есть образ. Подтвердите его той программой, которая его послала, или подождите 3 минуты, пока ствол вернётся к старому; затем повторите обновление.
update-reason-no-trial = на пробе нет образа, который подтверждается словом. Возможно, ствол вернулся к старой программе: повторите обновление. Если образ всё же на пробе, потеряна запись о нём: поможет только более новая версия или нажатие кнопки на плате, пока обновление начинается.
update-reason-word = слово не от этого обновления: его начала другая программа или другой компьютер. Продолжите там; или подождите 3 минуты, пока ствол вернётся к старому, и повторите обновление.
update-reason-flash = флеш-память не читается или не пишется. Повторите обновление; если случится снова, она неисправна.
update-reason-not-ready = его состояние уже не позволяло этого. Проследите, чтобы он оставался в дежурном положении и заблокированным, и повторите обновление.
update-other-sender = Тем временем другая программа начала другое обновление этого ствола. Больше ничего не отправлено: выясните, какое из двух нужно, и прекратите другое.
update-stalled = Ствол отвечает, но обновление не продвигается (есть { $done } байт из { $size }). Повторите обновление; если случится снова, перезапустите ствол.
update-silent = Ствол должен был перезапуститься с новым образом и не отвечает: { $error } Неподтверждённый образ через 3 минуты после запуска сам уступит место старому. После этого запросите состояние и повторите обновление.
update-went-back = Версия { $wanted } была на пробе и не осталась: работает { $running }, блокировка прежняя. Ответа от неё на пробе не было. Если тем временем не работала линия или этот компьютер спал, повторите обновление. Иначе на этом стволе она, возможно, сбоит при запуске: не отправляйте образ снова, пока не разберётся его изготовитель.
update-trial-ended = Версия { $wanted } на пробе отвечала, но проба кончилась до подтверждения: работает { $running }, блокировка прежняя. Если тем временем не работала линия, пропадало питание или этот компьютер спал, повторите обновление. Иначе образ на этом стволе сбоит: не отправляйте его снова, пока не разберётся его изготовитель.
update-not-noted = Здесь не удаётся записать, каким ствол был до перезапуска, поэтому ничего не назначено: { $error }. Устраните причину; та же команда продолжит.
update-changed = На пробе ствол был не таким, как прежде, поэтому новый образ не подтверждён, и снова работает { $running }. { $what } Не отправляйте этот образ снова, пока не разберётся его изготовитель.
update-changed-still = На пробе ствол был не таким, как прежде, поэтому новый образ не подтверждён; что снова работает старый, пока не видно. { $what } Запросите состояние через 3 минуты; если проба не кончится и тогда, выключите и включите питание ствола.
update-absent = { $subsystem } прежде отвечал, а теперь не отвечает.
update-new-fault = У { $who } флаг { $flag }, которого не было.
update-unreadable = Состояние не читается: { $error }

# decode_error.rs: why bytes cannot be decoded.
at-byte = байт { $offset }: { $what }
header-expected = заголовок записи — 4 байта, осталось { $got }
data-expected = data_size обещает { $size } байт, осталось { $got }
other-size-expected = { $got } байт данных: у этой записи такого размера не бывает
other-value-expected = значение { $got } вне допустимых пределов
request-unknown = неизвестный запрос { $got }
frame-start-expected = кадр начинается с FF C0, а здесь { $got }
escape-expected = после DB может следовать только DC или DD, а здесь { $got }
crc-expected = CRC должна быть { $crc }, в кадре { $got }
crc32c-expected = CRC-32C должна быть { $crc }, в кадре { $got }
frame-end-expected = кадр не завершён байтом C0
frame-too-long = кадр длиннее { $got } байт, которые хранит приёмник
bytes-wrong = байты не соответствуют протоколу ({ $got })
