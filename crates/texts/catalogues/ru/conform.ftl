## What the conformance tester says: what an item requires, what was found, the report.

# bench.rs
records-carried = соединение передаёт одни записи
interrupted = прервано
one-answer = §1/10: один ответ на кадр
another-frame-came = вслед пришёл ещё один кадр
answer-frame = §1/10: кадр ответа
nothing-within = ничего за { $ms } мс
frame-without-errors = §L/2: кадр без ошибок
addresses-swapped = §L/6: dst и src запроса, переставленные
whole-records = §2: целые записи
status-known = §2/5: статус от 0 до 18
one-answer-record = одна запись ответа на этот запрос
answer-without-data = ответ без данных
locked-out = ствол заблокирован
word-of-flags = §3.3: слово флагов
bytes-of-drive = §3.3: 8 байт привода
subsystem-missing = нет { $name }
no-such-subsystem = нет такой подсистемы
within = { $what }, не позже { $seconds } с
not-so = этого нет
flags-become = { $name }: флаги { $set } есть, { $clear } нет
id-and-values = §3.4: идентификатор и значения int32
ok-once-answered = §3.4/2: Ok, когда блок ответил
parameter-missing = у ствола нет параметра { $name }: перечень наш
taken-once-free = §3.5/7: принято, когда блок свободен

# run.rs
as-before-the-test = всё как до проверки
link-failed = связь: { $error }
not-moved = не проверялось: ответ нарушает протокол, покой ствола не виден, поэтому ствол не приводится в движение
expected-and-found = ожидалось: { $expected }; получено: { $found }

# safety.rs
at-work = ствол работает (что-то движется): сейчас он не проверяется
program-or-search-runs = идёт программа или поиск: ствол сейчас не проверяется
locked-out-by-others = ствол заблокирован по неизвестной причине. Возможен только --read-only
valve-not-closed = затвор не закрыт: сначала закройте его
moves-unasked = { $name } движется или открывается без запроса: послан Stop All
stop-all-stops = §3.2/1: Stop All останавливает всё
still-moves = что-то ещё движется

# checks/fold.rs
one-state-of-deployer = не более одного состояния Deployer
position-asked-for = заданное положение
stays-wrapped = остаётся свёрнутым
ok-or-accepted-from-all = Ok или Accepted от всех
nothing-is-done = ничего не делается
deploying-then-deployed = Deploying, затем Deployed
deploying-until-deployed = Deploying до Deployed
goes-on-deploying = продолжает разворачиваться
between-the-states = ни одного из четырёх состояний
no-place-in-between = у Deployer нет промежуточных положений
under-way = в пути
stops = останавливается
stays-deployed = остаётся развёрнутым
deployer-draws-too-little = Deployer потребляет слишком мало
not-wrapped = не свёрнут

# checks/limits.rs
no-such-drive = нет привода такого типа
taken-once-unit-free = Ok или Accepted, когда блок свободен
busy-for-moment-only = Busy лишь ненадолго
limits-stay-on = пределы остаются включены
nothing-changes = ничего не меняется
previous-limits-are-reported = сообщаются прежние пределы
same-limits-again = те же пределы снова
old-limits-until-on = старые пределы до On
limit-taken-is-in-force = взятый предел действует
old-limits = старые пределы
only-present-position = InvalidValue, кроме текущего положения
too-little-room = слишком мало места
runs-on-until-stopped = движется до остановки

# checks/link.rs
an-answer-to = ответ: { $what }
no-answer-to = нет ответа: { $what }
good-frame-after = на верный кадр после него
wrong-crc = неверная CRC
datagram-is-one-frame = датаграмма — это один кадр
frame-after-noise = кадр после шума
no-early-answer = нет ответа до конца кадра
frame-sent-byte-by-byte = кадр, посланный по байту
two-frames-at-once = два кадра подряд: два ответа по порядку
db-00-no-escape = DB 00 — не экранирование
new-frame-after-three-bytes = C0 после трёх байт начинает новый кадр
probe-swapped = проба с переставленными dst и src
frame-for-another = кадр для другого адреса
frame-from-own-address = кадр с собственным адресом в src
frame-too-long = кадр длиннее предела
another-monitor = на линии есть другой ствол
answers-in-its-name = ответ на пробу от его имени
probes-limited = ответ на 255 проб сразу, затем на одну каждые 512 мс
request-after-probes = запрос после проб
frame-not-known = ствол не знает этого кадра: он наш
answer-with-crc32c = и ответ с CRC-32C
wrong-crc32c = неверная CRC-32C
answered-at-first-try = на каждый кадр — один ответ, с первого раза (нет ли помех на линии?)
no-second-answer = второго ответа нет
same-frame-again = тот же кадр снова
one-connection-only = на этой среде соединение одно
answer-to-who-asked = ответ идёт спросившему
answer-on-second-connection = ответ по второму соединению
on-first-connection = по первому соединению
link-frames-carried = соединение передаёт кадры
answer-to-each-record = ответ на каждую запись

# checks/memory.rs
parameters-not-saved = сохранить можно не все параметры: ничего не стирается
nothing-is-erased = ничего не стёрто
copy-is-written-back = копия записана обратно
memory-was-not-erased = память не стиралась
nothing-to-ask = запрашивать было нечего
ok-once-stored = Ok, когда сохранено

# checks/motion.rs
speed-while-moves = скорость в движении
arrives-at = в { $at } ± { $tolerance }, в покое
new-limits = новые пределы
stays-at-rest = стоит, где остановлен
buffer-holds-all-answers = в буфер помещаются все ответы
move-after-no-room = Move после NoRoom не исполняется
two-answers = два ответа
wrong-data-from-addressee = WrongData от адресата
one-wrong-data = один WrongData
drive-draws-too-little = привод потребляет слишком мало
overload-over-max-current = AmperageOverload выше MaxCurrent
direction-refused = это направление отклоняется
flag-after-stop = флаг 3 с после остановки

# checks/params.rs
own-parameters-unknown = наши параметры неизвестны
read-back-at-once = читается сразу
read-back-later = и позже
value-as-set = значение как задано
no-stored-programs = нет записанных программ
all-values-of-array = все значения массива
accepted-with-id = Ok или Accepted с идентификатором
own-parameters-missing = наши параметры неизвестны
cached-then-accepted = Cached, затем Accepted
units-new-value = новое значение блока
no-remote-drive = нет удалённого привода
new-value-is-read = читается новое значение
ok-once-value-stored = Ok, когда значение сохранено
accepted-then-ok = Accepted, затем Ok
accepted-for-new-value = Accepted для нового значения
accepted-while-turning = Accepted, ещё не сохранено, пока привод движется
ok-after-motion = Ok после движения
no-bad-power-before = прежде не было BadPower
box-temperature = в корпусе слишком тепло или холодно

# checks/programs.rs
within-sector = в пределах сектора
closed-valve-stays-closed = закрытый затвор остаётся закрытым
no-program-runs = программа не идёт
whole-sector = вся ширина и больше одной строки сектора
raised-by-correction = ствол на 5° выше линии визирования
aimed-at-centre = наведён в центр
no-ballistics-fault = без баллистики нет её флагов
narrowest-jet = самая узкая струя
paused-for-3-s = приостановлена на 3 с
where-move-sent = там, куда послал Move
on-around-point-reached = дальше вокруг достигнутой точки
program-goes-on = программа продолжается
inside-limits = в пределах
outside-limits-stays = OutsideLimits до следующего запуска
no-sector-is-outside = нет сектора вне пределов
new-sector = новый сектор
point-after-point-then-end = точка за точкой, затем конец
starts-over = начинается снова
trajectory-in-use = Trajectory7 не пуста
wrong-data-or-invalid-value = WrongData или InvalidValue

# checks/reads.rs
answers-do-not-fit = ответы не помещаются в буфер
bytes-from = { $size } байт от { $from }
ok-with-structures = Ok со структурой каждой подсистемы
same-flags-as-subsystem-alone = те же флаги, что у подсистемы отдельно
unused-flags-are-0 = флаги без значения равны 0
supply-voltage-in-v = напряжение питания в В
not-open-and-closed = не открыт и закрыт сразу
temperatures-and-humidity = температуры в 0,1 °C и влажность в %
one-state-at-most = не более одного состояния
no-button-is-pressed = ни одна кнопка не нажата
speed-0-at-rest = скорость 0 в покое
no-conn-lost-after-request = нет ConnLost после запроса управления
no-conn-lost-early = нет ConnLost раньше времени
conn-lost-after-silence = ConnLost после 3 с без управления
conn-lost-without-control = ConnLost: управления не было
reads-are-no-control = чтение — не управление
values-of-parameter = столько значений, сколько у параметра
id-comes-back = идентификатор возвращается
ok-once-fetched = Ok после получения
parameters-are-unset = параметры не заданы
every-parameter = все параметры таблицы
values-in-range = значения в пределах таблицы
limits-in-order = int32 min и max, min не больше max
limits-of-parameters = пределы, заданные параметрами
no-drive = нет приводов
every-drive-in-order = каждый привод, в порядке цепочки
size-of-crash-data = 80 или 48 байт
words-of-fault-info = слова GetParam General FaultInfo
size-of-hotbeds = FE 23 и n × 20 байт, n = 0…4
hotbeds-brightest-first = не более 4 очагов, ярчайший первым
data-of-hotbeds = данные GetParam Hotbeds

# checks/records.rs
answers-to-this-request = ответы на этот запрос
ids-of-table = идентификаторы таблицы §1
general-answers = General отвечает
general-answers-last = ответы в порядке цепочки, General последний
each-answers-to-all = каждая подсистема, отвечающая сама, отвечает и на All, один раз
general-alone = только General
answer-to-each-request = ответ на каждый запрос, по порядку, в одном кадре
all-answers-or-no-room = все ответы либо NoRoom
two-no-rooms = NoRoom от подсистемы, которой не хватило места, затем одна от General
nothing-after-no-room = после NoRoom — ничего
answers-then-no-room = ответы, затем NoRoom
bytes-of-status = D4 C2 00 0A и 10 байт
bytes-of-crash-data = 06 C2 00 и сведения об отказе
as-with-status-0 = как при status 0
cut-record-is-wrong-data = целая запись — ответ, обрезанная — WrongData
own-request-id = свой номер запроса
ok-from-all-stoppable = Ok или Accepted от каждой останавливаемой подсистемы, в порядке цепочки

# checks/search.rs
found-when-hotbeds = Found, когда есть очаги
not-canceled = без Canceled
search-goes-on = поиск продолжается
valve-stays = затвор остаётся
next-start-clears = следующий запуск снимает
ends-at-once = заканчивается сразу
justified-or-fault = Justified либо DeviceFault, если мишени нет

# checks/service.rs
ok-from-all = Ok или Accepted от каждой подсистемы, в порядке цепочки
not-locked-out = не заблокирован
set-param-works = SetParam работает
get-param-works = GetParam работает
ok-from-general = Ok от General, когда сохранено
accepted-until-stored = Accepted, пока снятие не сохранено
does-not-restart = не перезапускается
answers-after-restart = снова отвечает после перезапуска
line-too-slow = линия слишком медленна, чтобы это увидеть
restarting-and-readable = Restarting, чтение отвечает
accepted-is-kept = принятое сохранено
nothing-moves-after-start = после запуска ничего не движется
sensors-show-deployed = датчики показывают: развёрнут

# checks/timed.rs
moves-while-repeated = движется, пока Move повторяется
set-param-and-move-taken = SetParam и Move приняты
moves-while-renewed = движется, пока MoveHold продлевается
renewal-starts-nothing = продление ничего не запускает

# checks/update.rs
no-update-over-link = ПО этого ствола по линии не обновляется
update-under-way = идёт обновление: его не трогают
has-update = ПО этого ствола обновляется по линии
report-of-24-bytes = отчёт из 24 байт от General
report-possible = отчёт с фазой от 0 до 4, областью 1 или 2, принято не больше, чем есть, а в фазе 0 — ничего
same-software = то же ПО, и обновления нет
software-parameters = SoftwareVersion, SoftwareSlot и SoftwareHash у General говорят то же, что отчёт
software-not-set = AccessDenied: работающее ПО не задаётся
nothing-carried-out = ничего не выполнено: отчёт прежний
wrong-data-without-report = WrongData без отчёта
orders-accepted = в дежурном положении и под блокировкой указание принимается
order-waits-no-more = указание больше не ждёт
not-started = заголовок ({ $what }) ничего не начинает: причина { $reasons }
not-carried-out = не выполнено: причина { $reason }
header-no-image = не образ
header-format = другой формат
header-field = невозможное поле
header-revokes = отзывает собственный ключ
header-board = другая плата
header-forged = подписан не изготовителем
header-large = больше области

# checks/water.rs
valve-stays-closed = затвор остаётся закрытым
valve-stays-open = затвор остаётся открытым
stop-all-stops-valve = Stop All останавливает затвор
open-valve-stays-open = открытый затвор остаётся открытым

# report/: the report, as text and as a page.
pass = соответствует
fail = ошибка
differs = иначе
not-applicable = неприменимо
expected = ожидалось
found = получено
summary = --{ $level }: соответствует { $pass }, ошибок { $fail }, отличий от наших толкований { $differs }, неприменимо { $not }; кадров { $frames } (повторено { $repeats }) за { $s } с
broken-off = Прервано
not-restored = НЕ ВОССТАНОВЛЕНО
title = Проверка лафетного ствола
nothing-failed = Ошибок нет
something-failed = Есть ошибки
subsystems = Подсистемы
test = Проверка
statement = Утверждение
result = Итог
observed = наблюдалось
ours = наше
bytes = Байты
not-testable = Что по линии проверить нельзя
