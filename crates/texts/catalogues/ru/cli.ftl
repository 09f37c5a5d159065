## What the program says on the command line, in the terminal and in its pictures.

# angle.rs
two-angles-expected = ожидаются два угла через запятую, например `-20deg,3deg` или `-1200,180`
unit-mm = мм
nozzle-not-mm = `{ $text }`: положение насадка — целое число мм, например `30` или `30mm`
not-an-angle = `{ $text }` — не угол: пишите угловые минуты (`1200`, `1200'`) или градусы (`20deg`, `12.5°`, `12°30'`), не более ±32767' (546°)

# cli.rs
one-of-names = ожидается одно из: { $names }
seconds-from = ожидаются секунды, { $least }…3600

# cmd/backup.rs
subsystem-and-name-expected = ожидаются подсистема и имя, например Vertical.Speed
file-exists = { $name } уже есть; --force заменит его
parameters-saved = { $name }: параметров: { $count }
parameters-not-set = ; не заданы: { $list }
parameters-missed = Ствол не отдал эти параметры, поэтому файл не записан: { $list }. Проверьте блок, в котором они находятся, и повторите команду.
reading-parameters = чтение параметров
no-differences = Различий нет.
heading-parameter = параметр
heading-monitor = ствол
parameters-absent = Пропущено, у этого ствола их нет: { $absent }
restore-interrupted = Прервано. Та же команда продолжит с этого места.
restore-incomplete = Восстановлено не всё. Устраните причину и повторите команду: она запишет только недостающее.
other-subsystems =
    Файл от ствола с другими подсистемами.
      файл:  { $file }
      ствол: { $present }
    --except General.Chain оставит подсистемы ствола, --force запишет те, что в файле.
other-address =
    Файл от ствола с адресом { $file }, у этого адрес { $monitor }.
    --except General.Address оставит адрес ствола, --force запишет тот, что в файле.
file-without-end = { $name }: по файлу этого формата не видно, где он кончается. Убедитесь, что он полный.
parameters-differ = отличается параметров: { $count }
writing-parameter = запись { $name }
retrying-parameter = { $name }: занято или нет ответа, пробую снова
reading-back = контрольное чтение
nothing-to-write = Различий нет: записывать нечего.
takes-effect-after-restart = Подействуют после `lafet restart`: { $list }
reads-back-as = читается обратно как { $values }
cannot-write-file = не удаётся записать { $name }

# cmd/bus.rs
bus-addresses-expected = ожидаются адреса вида 1-8,129: у стволов 1…127, у пультов 129…254
line-never-open = { $url }: { $why }. Линия ни разу не открылась: проверьте URL и наличие порта.
bus-needs-line = нужна линия; запустите `lafet sim` и укажите URL, на котором он слушает.
bus-needs-addresses = у записей без кадров нет адресов, и магистрали из них не бывает.
controller-not-console = role=active — для пультов, а это контроллер.
cannot-listen = нельзя открыть { $place }
addresses-lent = С --listen адреса { $first }…{ $last } выдаются программам, поэтому { $address } не может быть адресом пульта.
line-open = { $url }: открыта
line-retrying = { $url }: { $why }; пробую снова
listening-for-controller = слушаю, нет ли другого контроллера: { $s } с
at-baud = {" "}на скорости { $baud } бод
second-controller = { $url }: на этой магистрали есть контроллер: он слышен{ $at } (адрес { $controller }). Второй передавал бы в его очередь, поэтому этот не начал работу и ничего не передавал. Отключите другой контроллер или работайте на магистрали как пульт (role=active и свой src=). С --force контроллер всё же начнёт работу.
bus-at-other-speed = { $url }: на этой линии идёт обмен{ $at } ({ $who }), а не на скорости из URL. Контроллер не начал работу и ничего не передавал. Исправьте baud= в URL; с --force он всё же начнёт работу.
bus-line-unreadable = { $url }: приходят байты, которых никто не запрашивал и которые ни на одной обычной скорости не складываются в кадры: помехи. Проверьте согласование, смещение и экран линии; подробнее — `lafet doctor`.
others-on-bus = { $url }: без контроллера передаёт { $who }. На магистрали ему нужен role=active, иначе он мешает другим.
address-lent = программа на { $from }: выдан адрес { $address }
program-disconnected = программа с адресом { $address } отключилась
device-controller = контроллер
device-monitor = ствол { $a }
device-console = пульт { $a }
device-here = { $who }: на связи
device-dropped = { $who }: не отвечает, отключён; опрашивается каждую секунду
bus-counters = кадров отправлено { $sent }, переслано { $passed_on }; запросов пультов { $requests }, ответов { $answers }, повторов { $repeated }; посторонних { $strays }; не отправлено от программ { $dropped }

# cmd/bus_ask.rs
nobody-on-bus = На магистрали ни одно устройство не отвечает.
nothing-asked-yet = Запросов ещё не было.
no-controller-answers = Контроллер магистрали не отвечает на { $endpoint } (адрес { $controller }, попыток: { $tries }). На своей линии он отвечает только пультам, каждому в его очередь: добавьте в URL role=active и свой src= (129…254). Программам на --listen `lafet bus` это не нужно.
not-a-controller = Отвечает не контроллер магистрали.

# cmd/calibrate.rs
fitted-diameter = NozzleDiameter { $diameter_mm } мм: выстрелов { $count }, среднеквадратичный промах { $rms } м, наибольший { $worst } м.
shot-range = дальность, м
shot-miss = промах, м
fitted-table = Таблица поправок для { $distance_m } м, атм → градусы: { $degrees }
written-to-monitor = Записано в ствол.
nothing-written = Ничего не записано.
no-diameter-fits = Ни при каком диаметре насадка баллистика не сходится с этими выстрелами (лучший даёт промах { $worst } м). Проверьте давление, возвышение и дальность каждого и то, что струя была самой узкой; ничего не записано.
jet-too-short = Струя не достаёт до { $distance_m } м ни при каком давлении: укажите меньшее --distance. Ничего не записано.
shot-expected = ожидаются давление 1…25 атм, возвышение −15…75 градусов, дальность 1…200 м: 7.9,15,39
millimetres-expected = ожидаются миллиметры, { $least }…{ $most }

# cmd/chip.rs
chip-reset = программа перезапущена
chip-crashed = отказ программы, она запущена снова; что записано, покажет `lafet crash`
chip-one-address = С --on qemu слушать можно в одном месте: tcp://УЗЕЛ:ПОРТ, порт не 0.
chip-first-image = `{ $file }`: первый образ новой платы — для платы `{ $board }` и области A. Для чего этот, покажет `lafet image show`.
emulated-chip = эмулируемый контроллер

# cmd/conform.rs
no-such-test = Проверки `{ $wrong }` нет; все покажет `lafet conform --list --erase`.
conform-takes-long = Около десяти минут на настоящем стволе, с водой и движением. Ctrl-C прекращает проверку и возвращает всё как было.
interrupted-restoring = Прервано: всё возвращается
restoring-everything = Всё возвращается
conform-lost-monitor = Ствол больше не отвечает и, возможно, ещё движется. До { $seconds } с продолжаются попытки связаться с ним, остановить его и вернуть всё как было; Ctrl-C дважды прекращает их. При опасности сразу нажмите аварийный останов.
cannot-write = не удаётся записать
conform-given-up = Прервано, прежде чем ствол остановился. Если связь была, последним отправлен Stop; восстановлено не всё, ствол может двигаться, вода — течь. При опасности нажмите аварийный останов.
conform-cut-off = Связь прервана, покоя ствола не видно: возможно, он ещё движется, вода, возможно, течёт. Нажмите аварийный останов.

# cmd/coverage.rs
cannot-read-site = не читается { $shown }
site-too-long = { $shown }: больше 1 МиБ; это не файл объекта

# cmd/plan.rs
cannot-read-drawing = не удалось прочитать чертёж { $shown }

# cmd/decode.rs
neither-hex-nor-file = `{ $text }` — не шестнадцатеричные байты (как `ff c0 01 81`) и не файл
hex-ends = Вход шестнадцатеричный до символа { $offset }, но не дальше. Укажите --raw, если это не текст.
cannot-read = не удаётся прочитать { $path }
frame-broken = Кадр с байта { $offset } испорчен: { $why }. Приёмник молча отбрасывает такой кадр.
no-frame = Кадров нет: кадр — это FF C0 … C0 с верной CRC (docs/protocol.md, link frame).

# cmd/demo.rs
demo-running =
    { $url }

    Имитация: резервуарный парк, три ствола и пожар. Вход не нужен: с других машин сюда не попасть.
    Попробуйте в другом терминале (demo.pcapng открывает и Wireshark: lafet dissector):
    { $list }Ctrl-C завершает. В терминале: lafet demo --terminal

# cmd/dissector.rs
home-not-set = HOME не задан: выведите разборщик в файл папки модулей Wireshark
cannot-write-dissector = не удаётся записать { $shown }
dissector-written =
    { $shown }
    Wireshark узнает протокол при следующем запуске.

# cmd/doctor.rs
severity-good = хорошо
severity-warning = внимание
severity-fault = неисправ.
monitor-reports = Ствол сообщает:

# cmd/exercise.rs
expectations-failed = Не выполнено ожиданий: { $failed }.
the-simulator = имитатор
simulator-failed = Отказ имитатора.
monitors-count = стволов: { $monitors }
minutes-count = { $minutes } мин
cannot-read-scenario = не читается { $name }
no-such-scenario = Нет файла `{ $name }` и сценария с таким именем. С lafet поставляются: { $known }.
cannot-write-path = не удаётся записать { $path }

# cmd/image.rs
numbered-key-expected = ожидаются номер ключа, от 0 до 15, и его файл, например 0=key0
board-name-expected = ожидается имя платы: от 1 до 16 видимых знаков ASCII
image-version-expected = ожидается от одного до четырёх чисел от 0 до 65535 через точку, например 1.2.3
layouts-expected = ожидаются самая старая и самая новая раскладка хранимых параметров, которые читает программа, например 1-2
key-made = { $file }: новый ключ. Им подписывают то, что стволы примут за своё ПО: храните его там, где его не прочитает никто другой, а копию — в сейфе.
public-key-other = В { $file } открытая половина ключа { $id }, а не { $given }.
public-key-not-one = { $file } — не открытый ключ: его записывает `lafet image public`.
key-not-one = { $file } — не ключ: байтов в нём { $is }, а не 32. Ключ создаёт `lafet image key`.
image-too-long = { $file } длиннее { $mib } МиБ: это не образ.
never-written-over = { $name } уже есть, и поверх него ничего не записывается: выберите другое имя.
image-not-one = { $file } — не образ: образ из программы делает `lafet image sign`.
image-other-format = { $file } — образ другого формата, чем известен этой программе: возьмите ту версию lafet, которой он сделан.
image-empty = { $file } пуст или больше, чем бывает образ: ничего не подписано.
image-revokes-itself = Образ не может отозвать ключ, которым он подписан: подпишите его другим ключом.
image-malformed = { $file }: в заголовке значение, которого не бывает. Файл повреждён: скопируйте его заново.
image-cut = { $file }: за заголовком байтов { $is }, а не { $size }. Файл неполный: скопируйте его заново.
image-changed = { $file }: программа не та, что была подписана (не совпадает SHA-256). Файл повреждён: скопируйте его заново.
image-signature-wrong = { $file }: подпись не соответствует ключу { $key }. Ни одна плата с этим ключом такой образ не примет.
image-other-key = { $file } подписан ключом { $key }, а в --public указан ключ { $given }: подпись не проверена.
image-board = плата
image-version = версия
image-size = байтов
image-slot = область
image-slot-either = любая
image-key = ключ
image-revokes = отзывает ключи
image-layouts = раскладки
image-hash = SHA-256 программы
image-signature = подпись
image-signature-unchecked = не проверена (--public)
image-signature-right = соответствует ключу
image-signature-bad = не соответствует ключу
image-signature-other = не проверена: другой ключ

# cmd/install.rs
cannot-write-to = не удаётся записать в { $shown }
pages-written = { $shown }: страниц: { $count }

# cmd/jog.rs
lease-expected = ожидаются секунды, 0,05…2
jog-needs-keyboard = Для jog нужна клавиатура: запустите в терминале. Из программы используйте `lafet move` и `lafet stop` либо `Drive::jog` библиотеки.
all-motions-ended = Больше ничего не удерживается.
drives-not-seen-at-rest = { $drives }: возможно, ещё движется, покоя не видно. Нажмите аварийный останов.
drives-stop-not-answered = { $drives }: возможно, ещё движется, на Stop нет ответа. Попытки до { $seconds } с; Ctrl-C прекращает их. При опасности сразу нажмите аварийный останов.
drive-at-rest = { $drive } остановлен в { $at }.
drive-taken-over = { $drive }: приводом теперь управляет { $by }.
drive-moves-in-spite = { $drive } движется, несмотря на Stop: нажмите аварийный останов.
drive-not-moved = { $drive } остался на месте: контроль пределов выключен, и при обрыве связи ствол не прекратит движение сам. Включите пределы или задайте время: `lafet param set general MoveTimeout 500`.
drive-state-unknown = Неизвестно, остановлен ли { $drive }: нажмите аварийный останов. { $error }
jog-keys = ←→ Horizontal  ↑↓ Vertical  + - Nozzle  пробел: Stop All  q: конец

# cmd/limits.rs
limits-usage = Пишите `limits ПРИВОД`, чтобы увидеть пределы, `limits off|on|reject [ПРИВОД]`, чтобы переключить их.

# cmd/motion.rs
done-then = исполнено,
stopped-before = { $drive } остановился в { $show }, не дойдя до { $to }. { $flags }
stopped-without-flag = { $who } остановлен; флаги не показывают почему. Возможно, Stop послал другой клиент.

# cmd/param.rs
takes-effect-later = {" "}Подействует после `lafet restart`.
value-stored = сохранено
value-accepted = принято, не подтверждено (ствол не сообщил о сохранении: он может двигаться или вовсе этого не сообщать)
value-in-force = действует, не сохранено
memory-not-written = Ствол не смог записать ЭНОЗУ (ConfigWriteFault): при сбросе это пропадёт. Проверьте питание и повторите.
values-allowed = { $name }: допустимо { $range }. { $text }
no-parameters = У этой подсистемы нет параметров.
no-values = (пусто)
read-only = только чтение
default-value = по умолчанию { $value }
after-restart = после перезапуска
may-be-on-remote-unit = может быть на удалённом блоке
whole-number-expected = ожидается целое число, десятичное или 0x

# cmd/ports.rs
no-serial-port = Последовательных портов нет. Подключите адаптер; `dmesg` покажет, распознан ли он.
port-free = свободен
port-no-permission = нет прав
port-in-use-by = занят:

# cmd/program.rs
program-number-expected = ожидается номер от 0 до 7
the-trajectory = траектория
the-program = программа
program-is-empty = пусто
program-centre = центр { $h } по горизонтали, { $v } по вертикали
program-sector = сектор шириной { $width }, высотой { $height }, строки через { $step }°
program-nozzle = насадок { $nozzle } мм
aimed-straight = прямая наводка
fire-away = до очага { $metres } м
trajectory-point = { $number }: { $h } { $v }, { $distance } м, выдержка { $seconds } с

# cmd/quench.rs
corrections-too-few = --corrections требует не менее двух значений: одно означало бы расстояние (§3.14)
no-such-program = --program { $program }: программы имеют номера от 0 до 7
program-empty = Программа { $program } пуста: ствол развернётся и наведётся на 0°, 0° (или на --centre), без сектора и без поправки на расстояние. Ничего не послано. Смотрите `lafet program list`, запишите её: `lafet program set { $program } …`, или добавьте --empty.
request-done = { $request }: исполнено
point-expected = ожидается горизонталь,вертикаль,метры,десятые доли секунды, например 20deg,-2deg,25,10

# cmd/record.rs
recording-extension = имя должно кончаться на .mcap или .pcapng
recorded = { $name }: кадров: { $frames }, байт линии: { $bytes }
polls-withheld = На этой линии доступ даёт контроллер, поэтому запросов нет: записывается то, что передают другие. С role=active и своим src= в URL ствол будет опрашиваться.
cannot-listen-tap = нельзя слушать { $address }
connect-tap = Подключите программу к tcp://{ $bound } вместо { $url }.
reconnecting = { $url }: { $error }; соединяюсь снова
tap-goes-on = Запись больше не ведётся; отвод по-прежнему передаёт всё.

# cmd/replay.rs
cannot-read-recording = не удаётся прочитать { $name }
replay-waits = tcp://{ $bound }: воспроизведение начнётся с первым соединением

# cmd/scan.rs
hosts-expected = ожидается 192.168.1.0/24 (не больше /20), 192.168.1.10-40, адрес или имя
scan-addresses-expected = ожидаются адреса, например 1-127, не больше 254
nothing-to-scan = framing=records ведёт к одному стволу без адреса: искать нечего.
probing-addresses = пробы по адресам
noise-before-scan = На линии идут байты, которые не складываются в кадры: обмен на другой скорости (baud=) или помехи. Проба могла бы столкнуться с чужим Stop, поэтому проб не было. Подробнее — `lafet doctor`; --insist всё же выполнит пробы.
others-before-scan = На линии идёт чужой обмен ({ $who }); проба могла бы столкнуться с чужим Stop, поэтому проб не было. --insist всё же выполнит их; кто есть на линии, знает контроллер магистрали.
answers-bare-records = голые записи
open-without-monitor = открыт, но ствол не отвечает
no-open-port = Открытых портов нет.
ports-examined = проверено портов: { $done } из { $all }, { $seconds } с
bus-controller = контроллер магистрали
console = пульт
crc32c-only = , только CRC-32C
two-have-address = , этот адрес у ДВУХ устройств
unit-ms = мс
others-after-scan = На линии идёт и чужой обмен ({ $who }): часть ответов могла пропасть.
broken-frames = Испорченных кадров: { $broken }. Подробнее — `lafet doctor`.
nobody-at-addresses = По адресам { $first }…{ $last } ни одно устройство не отвечает. Причину ищет `lafet doctor`.
no-monitor-found = Стволов не найдено.

# cmd/seek.rs
aligned = Отъюстировано: ось извещателя на { $horizontal }' левее и { $vertical }' выше.
no-fire-spots = Очагов загорания нет.
seek-deploying = развёртывание
seek-looks-at = осмотр: азимут { $horizontal }, возвышение { $vertical }

# cmd/send.rs
not-records = `{ $text }` — не последовательность записей: { $reason }

# cmd/serve.rs
one-of-words = одно из: { $words }
config-good = { $file }: ошибок нет; стволов: { $count }; адрес { $listen }
no-config = Нет конфигурации: ни { $first }, ни { $second } не существует. С чего начать: lafet serve --example > hub.toml. Посмотреть без стволов: lafet demo.
cannot-read-config = не читается { $file }
audit-good = записей: { $entries }, до последней ничего не изменено и не удалено; её хеш { $head }
audit-changed = Запись { $bad } — не та, что была сделана: изменена либо удалена предыдущая.

# cmd/service.rs
lockout-stored = Блокировка записана: после каждого перезапуска и пропадания питания ствол заблокирован, пока её не снимут.
lockout-unconfirmed = Блокировка действует. Ствол не сообщил, что записал её, поэтому пропадание питания может её снять: пошлите её ещё раз.
lockout-not-stored = Блокировка действует и не записана: следующий перезапуск её снимет.
release-stored = Снятие записано: после перезапуска блокировки не будет.
release-unconfirmed = Блокировка снята. Ствол записывает это чуть позже и не сообщает об этом: если питание пропадёт раньше, он запустится с блокировкой, и её надо будет снять ещё раз.
release-not-stored = Блокировка снята, и это не записано: после следующего перезапуска она снова включится.
no-crash-data = Данных об отказе нет.
no-hardware-fault = Аппаратных отказов не записано.
unknown-bits = неизвестные биты
crash-running = исполнялось

# cmd/shell.rs
motion-continues = Движение продолжается.
line-dropped = Не выполнено, так как введено до остановки: { $line }
script-line = Строка { $number }: { $line }
shell-in-shell = Оболочка уже запущена.
monitor-lost = { $name } не отвечает{ $why }
monitor-back = { $name } снова отвечает: { $state }.
shell-help =
    help — команды lafet, без URL. Tab дополняет. exit — выход.
    stop и Ctrl-C останавливают любое движение.
option-at-start-only = --{ $name } задаётся при запуске оболочки: `exit` и запустите её заново.
line-held-by-shell = Линию держит оболочка, а команде она нужна целиком: выполните её без оболочки.

# cmd/sim.rs
nothing-burns = ничего не горит; --fire az=30,range=25 зажигает очаг в 25 м, на 30° левее
radio-needs-frames = { $place }: с --radio нужны кадры, иначе потери незаметны.
radio-expected = `{ $part }`: ожидается rate=300…10000000, latency=0…10000 (мс), loss=0…1, errors=0…1
cannot-listen-sim = нельзя открыть { $place } (не запущен ли другой имитатор? порт 0 — любой свободный)
cannot-keep-memory = не удаётся сохранить память в { $path }
not-a-memory = { $path } — не память имитатора ствола, повреждён или создан прежней версией. Удалите файл, чтобы начать с новой памяти, или укажите другой.
own-key-of-simulator = Ключ 15 у имитатора свой: в --update-key укажите номер от 0 до 14.

# cmd/teach.rs
deployer-without-limits = Крайние положения Deployer определяются его датчиками: задать их нельзя.
old-limits-again = У { $drive } прежние пределы; они снова включены.
new-limits-already = { $drive }: действуют новые пределы: { $range }. Они включены.
limits-not-read = { $drive }: пределы включены. Какие, прочитать не удалось: см. `lafet limits { $drive }`.
limits-are-off = { $drive }: пределы { $range }. Теперь они выключены: в конце хода его остановит только перегрузка двигателя.
teach-keys = Подведите { $drive }: { $word } предел. Enter — принять, s — оставить прежний, q — отказаться.
limits-are-on = { $drive }: пределы включены: { $range }.
limit-taken = { $drive }: { $word } предел { $at }. Пределы: { $range }.
limit-taken-later = { $drive }: { $word } предел { $at }, вступит в силу после `lafet limits on { $drive }`.

# cmd/throw.rs
throw-step = --step: не меньше { $step_least }° и не больше { $lines_max } строк таблицы
throw-elevation = возвышение
throw-middle = середина, м
throw-greatest = наибольшая, м
throw-top = высота, м
throw-flight = полёт, с
throw-aside = снос, м
throw-simulator = имитатор: середина, м
throw-legend = Середина — смоченного пятна; наибольшая дальность — по крайним каплям; высота — верхних капель. В скобках — интервал, в котором лежат опубликованные данные, не вошедшие в подгонку (docs/physics.md).
throw-simulator-legend = У имитатора и `lafet coverage` струя компактнее, чем у лафетных стволов по данным изготовителей: её середина — в последнем столбце.
nozzle-of-monitor = Лафетный ствол
smooth-bore = Гладкий насадок
wind-from = ветер { $wind_mps } м/с с { $wind_from_deg }° от струи
still-air = штиль
throw-conditions = { $kind }: { $flow } л/с при { $pressure_mpa } МПа, отверстие { $outlet } мм, насадок на { $nozzle_mm } мм, { $height_m } м над землёй, { $wind }
wind-left = влево
wind-right = вправо
flow-expected = ожидается расход, например 20 (л/с) или 1200л/мин
pressure-expected = ожидаются { $least }…{ $most } МПа либо { $bar_least }…{ $bar_most } бар, например 8бар
elevation-expected = ожидаются градусы, например 30, либо 10..75, меньшее первым
nozzle-kind-expected = ожидается monitor или smooth

# cmd/top.rs
size-expected = ожидаются столбцы и строки, например 80x24
top-needs-terminal = Для top нужен терминал. `lafet top --once` выводит один экран текстом, с --json — объект на каждый ствол; `lafet watch --json` повторяет вывод.
state-not-known = о состоянии ничего не известно
cannot-draw = терминал
stop-not-sent = Stop All НЕ послан: нет связи
stop-not-answered = Stop All послан, ответа нет. При опасности сразу нажмите аварийный останов.

# cmd/tune.rs
tune-not-deployer = Deployer движется между датчиками крайних положений: настраивать нечего.
tune-runs-already = Приводы этого ствола уже настраивает другой lafet tune. Дождитесь его завершения или завершите его там.
tune-put-back = Прошлая настройка { $drive } была оборвана: { $name } { $from } → { $to }, как было до неё.
tune-not-put-back = В { $drive } могли остаться значения, нужные для измерения. Прежние записаны: их вернёт следующий lafet tune.
tuned-drive = привод
tuned-lag = StopLag, мс
tuned-error = ошибка в покое

# cmd/update.rs
update-runs-already = Этот ствол уже обновляет другая команда lafet update. Дождитесь её завершения или прервите её там.
update-two-images = Два образа должны быть одной версии и для одной платы: один собран для области A, другой для области B.
update-sending = передача: { $percent } % из { $size } байт
update-sending-left = передача: { $percent } % из { $size } байт, осталось { $left }
update-verifying = ствол проверяет принятое
update-committing = команда стволу попробовать новую версию
update-committed = назначено: ствол пробует новую версию
update-restarting = жду, когда ствол снова ответит
update-on-trial = новая версия работает, на пробе
update-confirming = подтверждение
update-confirmed = подтверждено
update-done =
    { $from } → { $to }, подтверждено.
    Аварийная блокировка ствола не снята: её снимает `lafet lockout off`.
update-done-trial =
    Версия { $to } была на пробе и подтверждена.
    Аварийная блокировка ствола не снята: её снимает `lafet lockout off`.
update-interrupted = Прервано здесь: { $far }. Ничего не отменено: та же команда продолжит.
update-interrupted-trial = Прервано здесь: { $far }. Если до этого не повторить команду, через 180 с после запуска ствол вернётся к старой версии.
update-goes-on = На чём остановилось: { $far }. Та же команда продолжит.
update-note-damaged = { $file } — неполная запись об обновлении. От неё ничего не зависит: она заменяется.
update-note-unreadable = У ствола есть образ, который назначен или на пробе, а то, что его подтвердит, не прочитать из { $file }. Подождите, пока ствол сам вернётся к старой версии, 180 с после запуска, или выключите и включите его питание. Затем повторите команду.
update-word-elsewhere = У ствола есть образ, который назначен или на пробе и послан не отсюда, поэтому здесь нечем его подтвердить. Повторите команду там, откуда он послан, или подождите, пока ствол сам вернётся к старой версии, 180 с после запуска.
update-other-image = У ствола есть другой образ, который назначен или на пробе и послан отсюда. Подтвердите его этой командой с тем образом или подождите, пока ствол сам вернётся к старой версии, 180 с после запуска.
update-row-version = версия
update-row-slot = область
update-row-running = работает
update-row-phase = обновление
update-row-image = хеш
update-row-order = последнее указание
update-row-trial = последняя проба
update-row-pending = назначение
update-row-lost = подтверждённая
update-in-service = постоянно
update-is-on-trial = на пробе: без подтверждения следующий запуск вернёт старую версию
update-phase-idle = с запуска не начиналось
update-phase-receiving = приём: есть { $done } из { $size } байт
update-phase-verifying = проверяется { $size } байт
update-phase-verified = проверено, не назначено
update-phase-committed = назначено: попробует следующий запуск
update-phase-unknown = фаза { $n }, неизвестная этой программе
update-digest-running = { $hash }…, работающего образа
update-digest-received = { $hash }…, принимаемого образа
update-order-done = выполнено
update-order-waits = ждёт
update-order-refused = { $why } (причина { $n })
update-trial-failed = не подтверждена, ствол вернулся к старой версии
update-commit-pending = ещё не отменено: до этого блокировка не снимается
update-confirmed-lost = версия, подтверждённая последней, больше не проходит проверку, работает более старая: отправьте её снова
update-site-hub-runs = Работает сервер объекта с конфигурацией { $file } или другая команда `lafet update --all` с этим файлом: связь со стволами у него. Обновляйте их с пульта сервера либо сначала остановите его.
update-site-hub-hidden = Не видно, пользуется ли сервер объекта папкой { $folder } (выполните команду от имени пользователя сервера или root)
update-site-unknown = В конфигурации нет ствола { $id }. Есть: { $known }.
update-site-not-ready =
    Ничего не изменено: эти стволы сейчас обновить нельзя:
    { $lines }
update-site-no-general = General не сообщает своего состояния. См. `lafet doctor`.
update-site-program = Идёт программа: завершите её (`lafet stop control`).
update-site-search = Идёт поиск или юстировка: завершите (`lafet stop detector`).
update-site-newer = Работает версия { $version }, она новее образа. Более старую ствол принимает только при нажатой кнопке на плате: обновите его отдельно.
update-site-beside-locked = Зона { $zone }: её защищает и { $id }, а на нём аварийная блокировка. Два ствола одной зоны одновременно не выводятся из работы: сначала снимите блокировку { $id }.
update-site-beside-silent = Зона { $zone }: её защищает и { $id }, и неизвестно, в работе ли он. { $error }
update-site-ready = { $id }: готов, версия { $version }
update-site-locking = { $id }: включается аварийная блокировка
update-site-releasing = { $id }: снимается аварийная блокировка
update-site-not-locked = Ствол не сообщает об аварийной блокировке, которая ему послана.
update-site-still-locked = Снятие послано, но аварийная блокировка осталась: возможно, её включил другой клиент.
update-site-line-given = Обновление выполнено. Тем временем линию занимала другая программа и могла тоже включить аварийную блокировку, поэтому она не снята.
update-site-one-done = { $id }: { $from } → { $to }, подтверждено; { $lockout }.
update-site-trial-done = { $id }: версия { $to } была на пробе и подтверждена; { $lockout }.
update-site-same = { $id }: версия { $to } уже работает. Ничего не изменено.
update-site-released = аварийная блокировка снята
update-site-locked-before = аварийная блокировка осталась, как была
update-site-locked-here = аварийная блокировка включена этой командой
update-site-unlocked = аварийной блокировки нет
update-site-seen = { $id }: версия { $version }, { $running }; обновление: { $phase }; { $lockout }.
update-site-unseen = { $id }: состояние сейчас не прочитать; { $lockout }.
update-site-go-on = Чтобы продолжить, повторите команду с `--only { $id }`, затем выполните `lafet -c "{ $url }" lockout off` (блокировку, которая уже была, команда не снимает), затем ту же команду для остальных.
update-site-summary = Сделано: { $done }. Не затронуты: { $rest }.
update-site-untouched = Завершено до каких-либо изменений.
update-site-done = Стволов, которые надо было обновить: { $count }. У всех работает версия { $version }.

# cmd/watch.rs
enter-ends = Enter — конец
ctrl-c-ends = Ctrl-C — конец

# connect.rs
listening-first = слушаю линию, прежде чем передавать: { $s } с
port-awaited = Порт { $port } занят программой { $program } ({ $pid }). Ждём его не более { $s } с. Если та программа его не отдаст: остановите ствол в ней или завершите её (`kill { $pid }`); аварийный останов самого ствола ничего не ждёт.
port-awaited-of = Порт { $port } занят другой программой, которой этому пользователю не видно. Ждём его не более { $s } с. Если та программа его не отдаст: остановите ствол в ней; аварийный останов самого ствола ничего не ждёт.
port-given = { $url }: программе { $program } ({ $pid }) нужно было передать запрос немедленно, например Stop, и порт отдан ей. Ничего не отправлено: посмотрите, зачем это было, и запустите эту команду снова.
port-given-away = { $url }: порт отдан программе { $program } ({ $pid }), которой нужно передать запрос немедленно, например Stop. Эта команда начнётся сначала, когда та программа закроет порт.
port-given-often = { $url }: другим командам { $times } раз нужно было передать запрос немедленно, и каждый раз порт отдан им. Посмотрите, зачем они, и запустите эту команду снова.
line-at-other-speed = { $url }: на этой линии идёт обмен на скорости { $baud } бод ({ $who }), а не { $own }. Запросы не отправлялись: они не дошли бы ни до кого и помешали бы другим. Впишите в URL baud={ $baud }, а если есть контроллер, то и role=active и свой src=.
controller-on-line = { $url }: на этой линии передаёт контроллер магистрали. Устройства магистрали передают только в свою очередь, которую он предоставляет, поэтому запросы не отправлялись. Впишите в URL role=active и свой src= (129…254) или отсоедините контроллер; с --insist запросы всё же будут отправлены. Stop, Close и Lockout on отправляются всегда.
line-not-frames = { $url }: приходят байты, которых никто не запрашивал и которые не складываются в кадры (их { $bytes }): обмен на другой скорости или помехи. Запросы не отправлялись: они могли бы столкнуться с чужим Stop. Подробнее — `lafet doctor`; с --insist запросы всё же будут отправлены. Stop, Close и Lockout on отправляются всегда.
others-on-line = { $url }: на линии идёт чужой обмен ({ $who }). Проверкам линия нужна целиком, поэтому запросы не отправлялись. Выключите или отсоедините других; с --insist запросы всё же будут отправлены, и помешать могут обе стороны.
waiting-for-late-answers = Ствол не отвечает на номера кадров, поэтому опоздавшие ответы неотличимы от нужных: ожидание { $s } с. Параметр late= в URL задаёт наибольшее опоздание; late=0, если соединением не пользуется другая программа.
which-monitor = Какой ствол? Укажите его URL через -c (или в LAFET_CONNECT), например `-c tcp://192.168.1.50:10485?addr=1`, `-c serial:///dev/ttyUSB0?baud=19200` или `-c sim:` для имитатора.
sim-options = sim: не поддерживает `{ $key }={ $value }`. Параметры: profile={ $profiles }, seed=7, speed=20, fire=az=30,range=25,size=1.5 и addr=1.

# coverage/file.rs
site-needs-monitor = нужен хотя бы один [[monitor]]
coverage-no-places = Места стволов не заданы: укажите у них `at = [восток, север]`, `heading` и `height`.
site-needs-site = нужен раздел [site]
tables-at-most = { $count }, не больше { $most }
monitors-with-one-name = два ствола с именем `{ $name }`
body-needs-size = нужен `radius` (цилиндр) либо `size = [длина, ширина]` (параллелепипед)

# coverage/picture.rs
picture-legend = струи в пределах 90 % дальности, худший ветер; кружки — слабейшие точки
jets-none = нет струй
jets-one = одна
jets-two = две
jets-three = три и больше

# coverage/report.rs
coverage-shares = Доля ячеек с одной струёй / с двумя и наименьшее число струй на ячейку (90 %):
coverage-head = { $name }: { $east } × { $north } м, ячейки { $cell } м, под защитой { $protected }; стволов: { $count }, одновременно работают { $flowing } при { $pressure } МПа
coverage-wind-from = с { $from }°, { $speed } м/с
coverage-wind = ветер
coverage-reached = достигается
coverage-90 = 90 % дальности
coverage-75 = 75 % дальности в штиль
coverage-fewest = наименьшее
weakest-points = Слабейшие точки (90 %):
weakest-fewest = струй при худшем ветре: { $fewest }
weakest-still = в штиль: { $still }
lost-monitor-costs = Цена потери ствола (90 %, худший ветер):
cells-without-jet = без струи { $none }
cells-with-one = с одной вместо двух { $one }

# decode/mod.rs
probe-frame = (проба)
record-cut-short = запись оборвана
before-byte = до байта
count-skipped = байт пропущено
count-crc = ошибок CRC
count-escapes = ошибок экранирования
count-too-long = слишком длинных кадров
count-cut-short = оборванных кадров
decode-summary = { $bytes } байт: кадров: { $frames }, записей: { $records }, оборванных записей: { $malformed }, пропущено байт: { $bytes_skipped }{ $why }

# demo/drawing.rs
cannot-write-picture = не удалось записать рисунок

# demo/picture.rs
unit-s = с
q-quits = q — выход
picture-monitor = {" "}ствол{" "}
picture-water = { $pressure } атм  { $flow } л/с{" "}
unit-a = А
picture-fire-spot = очаг { $number }: { $azimuth }, { $elevation }, яркость { $brightness }
picture-exchange = {" "}запросы и ответы{" "}

# demo/plan.rs
plan-title = {" "}план, м{" "}
plan-out = {" "}потушен

# demo/script.rs
demo-standby = дежурное положение
demo-standby-done = Дежурное положение: ствол свёрнут, затворы закрыты.
demo-found-nothing = Поиск ничего не нашёл: находится ли очаг в пределах ±60° и на виду?
demo-fire-burns = Очаг ещё горит.
demo-search = поиск
demo-search-endless = Поиск не заканчивается.
demo-quench = тушение
demo-no-flames = Пламени там больше не видно.
demo-closing = Очаг не гаснет: закрываю.
demo-valve-open = Valve1 не закрывается.
demo-not-put-out = Очаг не потушен.
demo-distance-seen = Основание пламени видно под углом { $angle } с высоты { $height_m } м: расстояние { $height_m } / tg = { $estimate_m } м.
demo-distance-told = Край под углом { $angle } не даёт расстояния; по карте оператора { $told_m } м.
demo-stowing = сворачивание
demo-not-stowed = Ствол не сворачивается.
demo-standby-again = Снова дежурное положение.

# demo/stage.rs
no-port-free = на 127.0.0.1 нет свободного порта
stage-fire-breaks-out = возник очаг{ $fire }: азимут { $azimuth }°, расстояние { $range } м
stage-water-reaches = вода достигла очага{ $fire }
stage-fire-out = очаг{ $fire } потушен
stage-fire-again = повторное воспламенение: очаг{ $fire }
stage-jet-begins = струя пошла
stage-jet-ends = струя прекратилась
stage-water-in-barrel = ВОДА В СВЁРНУТОМ СТВОЛЕ

# demo/summary.rs
never = никогда
time-to-detect = до обнаружения
time-to-water = до подачи воды на очаг
time-to-out = до ликвидации
time-to-standby = снова в дежурном положении
water-used = израсходовано воды
unit-litre = л
requests-and-answers = запросов / ответов
demo-summary = Итог (время имитации от возникновения очага, seed { $seed }): потушено очагов: { $out } из { $fires }

# describe.rs
value-invalid = недостоверно
unit-v = В
unit-atm = атм
unit-lps = л/с
unit-mmps = мм/с
unit-degps = °/с
place-horizontal = горизонталь
place-vertical = вертикаль
place-nozzle = насадок
place-deployer = развёртывание
place-housing = корпус
spot = очаг загорания
spot-azimuth = азимут
spot-width = ширина
spot-height = высота
spot-brightness = яркость

# failure.rs
requests-refused = Отклонено запросов: { $count }; первый: { $first }
interrupted = Прервано.
answers = отвечает
exchange-request = запрос
exchange-answer = ответ{" "}
why = Почему
try = Попробуйте
standard-streams = стандартный ввод или вывод

# hub/faults.rs
part-vertical = Привод вертикали
part-horizontal = Привод горизонтали
part-nozzle = Насадок
part-deployer = Механизм развёртывания
part-valve1 = Затвор 1
part-valve2 = Затвор 2
part-box = Блок управления
part-buttons = Кнопочный пост
part-ext-buttons = Удалённый кнопочный пост
part-water = Вода
part-detector = Извещатель
part-monitor = Ствол
fault-temperature-dead = Датчик температуры не отвечает
fault-temperature-frozen = Показание температуры не меняется
fault-temperature-drift = Показание температуры уходит вверх, 0,1 °C в секунду
fault-heater = Обрыв цепи обогревателя
fault-button-short = короткое замыкание
fault-button-break = обрыв
fault-button-bounce = контакт дребезжит
fault-button = Кнопка { $button }: { $what }
fault-motor-open = Обрыв цепи двигателя
fault-jam = Заклинило: не движется
fault-power-stage = Силовой каскад не работает, диагностики нет
fault-runaway = Силовой каскад пробит: движется без команды
fault-friction = Трение: ток выше допустимого
fault-flicker = Трение, показание тока с пропусками
fault-lag = Скорость запаздывает на 300 мс
fault-dead-band = Не движется медленнее 1 °/с или 1 мм/с
fault-droop = Скорость падает под нагрузкой, 0,4 °/с на 1 А
fault-backlash = Люфт редуктора 12′ или 1 мм
fault-stiff = Густая смазка: ток повышен
fault-encoder-dead = Положение не меняется
fault-encoder-reversed = Положение считается наоборот
fault-encoder-fast = Положение считается вчетверо быстрее
fault-encoder-jump = Положение скачком изменилось на 20° или 15 мм
fault-encoder-noise = Шум датчика положения, ±2′ или ±1 мм
fault-encoder-fault = Датчик положения сообщает о неисправности
fault-speed-dead = Датчик скорости показывает ноль
fault-speed-reversed = Датчик скорости с обратным знаком
fault-speed-fault = Датчик скорости сообщает о неисправности
fault-min-switch = Залип концевой выключатель min
fault-max-switch = Залип концевой выключатель max
fault-min-bounce = Дребезг концевого выключателя min
fault-max-bounce = Дребезг концевого выключателя max
fault-open-relay = Реле приварилось: открывается само
fault-valve-jam = Заклинило
fault-open-switch = Неисправна цепь датчика «открыт»
fault-close-switch = Неисправна цепь датчика «закрыт»
fault-close-stuck = Залип концевой выключатель «закрыт»
fault-blocked = Включена аппаратная блокировка
fault-open-bounce = Дребезг концевого выключателя «открыт»
fault-close-bounce = Дребезг концевого выключателя «закрыт»
fault-blocked-bounce = Дребезг контакта аппаратной блокировки
fault-unit-offline = Удалённый блок не отвечает
fault-unit-lossy = Удалённый блок: теряется половина обменов
fault-unit-protocol = Удалённый блок нарушает протокол
fault-unit-watchdog = Удалённый блок перезапущен сторожевым таймером
fault-remote-no-answer = Удалённые параметры: нет ответа
fault-remote-incomplete = Удалённые параметры: неполный обмен
fault-remote-bad-id = Удалённые параметры: неверный id
fault-remote-bad-value = Удалённые параметры: неверное значение
fault-remote-error = Удалённые параметры: ошибка
fault-pressure-break = Датчик давления: обрыв
fault-pressure-short = Датчик давления: замыкание
fault-pressure-frozen = Показание давления не меняется
fault-pressure-drift = Датчик давления уходит вниз, 20 мкА в секунду
fault-flow-frozen = Показание расхода не меняется
fault-flow-drift = Расходомер уходит вверх, 1 л/с за пять секунд
fault-pump-off = Насос не работает
fault-pump-weak = Насос даёт четверть давления
fault-supply-low = Питание ниже на треть
fault-supply-high = Питание выше на треть
fault-supply-dip = Провал питания 0,2 с при пуске привода
fault-supply-sag = Просадка питания, пока работает двигатель
fault-humidity = Датчик влажности не отвечает
fault-detector-dead = Извещатель не отвечает
fault-detector-saturated = Извещатель засвечен по всему полю
fault-dirty-lens = Загрязнено стекло извещателя
fault-memory-read = Память не читается
fault-memory-write = Память не записывается

# hub/mod.rs
folder-shared = В папку { $folder } могут писать другие пользователи, и в ней чужие файлы. Укажите в data отдельную папку.
folder-in-use = Папкой { $folder } уже пользуется другой сервер объекта: остановите его либо укажите другую папку data.
cannot-open-storage = не открывается хранилище
hub-failed = отказала часть сервера, подробности в журнале: он завершён
cannot-listen-hub = { $listen } занят или недоступен
no-users-yet =
    Пользователей ещё нет. Создайте администратора по одноразовой ссылке:
      { $link }
state-lost =
    Состояние не то, что было сохранено:
      { $list }
    Выясните причину; если есть копия всей папки, восстановите её. Продолжить без потерянного, с записью об этом: lafet serve --accept-lost { $words }

# hub/training.rs
kind-monitor = ствола
fire-kind-unknown = `{ $kind }` — не pool, pile, spray; либо очагов уже слишком много.
kind-fire = очага
kind-fault = неисправности
kind-scenario = сценария
kind-place = адреса
side-north = Север
side-north-east = Северо-восток
side-east = Восток
side-south-east = Юго-восток
side-south = Юг
side-south-west = Юго-запад
side-west = Запад
side-north-west = Северо-запад
side-middle = Центр
no-such-one = Нет { $kind } «{ $name }».

# interrupt.rs
cannot-catch-signals = не удаётся перехватить сигналы

# serve/listener.rs
listener-expected = ожидается tcp://УЗЕЛ:ПОРТ (?framing=records — записи без кадров), udp://УЗЕЛ:ПОРТ или pty, перед каждым можно поставить radio+; порт 0 — любой свободный

# shell/complete.rs
leave-shell = Выйти из оболочки
explain-command = Объяснить команду

# shell/words.rs
quote-open = Кавычка не закрыта.

# simulator.rs
speed-expected = ожидается множитель больше 0, не более { $speed_max }
profile-expected = ожидается одно из { $known }
no-such-fault = такой неисправности нет; список в docs/faults.md: horizontal-lag, valve1-jam, pump-off …
no-such-fault-but = такой неисправности нет; ожидается одна из: { $known }
fire-expected = az=ГРАДУСЫ (влево положительно) и range=МЕТРЫ, при желании size=МЕТРЫ, growth=М/С, reignites=1, lit=0, class=solid|hydrocarbon; например az=30,range=25,size=1.5

# surroundings.rs
wind-expected = ожидаются метры в секунду вперёд и влево, не более { $wind_max_mps }: -5,0 — встречный ветер
gusts-expected = ожидается доля среднего ветра, от 0 до { $gusts_max }; 0.15 — открытое место
glare-expected = az=ГРАДУСЫ (влево положительно, от -360 до 360), el=ГРАДУСЫ (от -90 до 90), size=ГРАДУСЫ (больше 0, до 90) и brightness=N (от 1 до 1000000): az=30,el=5,size=0.5,brightness=2000
wall-expected = from=ГРАДУСЫ и to=ГРАДУСЫ (правый и левый край, от -180 до 180), range=МЕТРЫ и height=МЕТРЫ (больше 0): from=-10,to=10,range=15,height=3
write-instead = пишите { $form }

# top/detail.rs
top-problems = Что не так
stale-for = УСТАРЕЛО,{" "}
stale-ago = назад

# top/frame.rs
page-list = 1 список
page-monitor = 2 ствол
page-link = 3 линия
list-selected = {"  "}{ $selected } из { $count }
list-alarms = {"  "}тревога: { $alarms }
list-stale = {"  "}устарело: { $stale }
top-keys = {" "}↑↓ ствол  Tab страница  1 2 3  PgUp PgDn прокрутка  ? клавиши  q выход
top-stop-key = {" "}s (ы)  СТОП ВСЕ: { $name }{" "}
keys-title = {" "}клавиши{" "}
keys-help =
    s (ы)        Stop All выбранному стволу, на любой странице
    ↑ ↓  k j     предыдущий, следующий ствол
    Tab Shift+Tab  следующая, предыдущая страница
    1 2 3        список, ствол, линия;  Enter: ствол,  Esc: список
    PgUp PgDn    прокрутить то, что не поместилось
    q  Ctrl-C    выход; этим ничего не останавливается

    !  предупреждение   !! тревога   серое: устарело, может быть уже не так
    Stop — единственный запрос этого экрана, который что-либо меняет.

# top/link.rs
chart-title = задержка по секундам; наибольшая
link-connecting = соединение
link-up = есть связь
link-down = нет связи
figures-later = Первые цифры — через секунду.
last-second = за секунду
link-of-all = линия
frames-unanswered = запросы, оставшиеся без ответа
frames-sent = кадров послано
frames-received = кадров принято
answers-accepted = ответов принято
frames-with-errors = кадров с ошибками (CRC, формат)
answers-not-in-time = ответов не в срок
frames-repeated = повторов
late-answers = запоздалых ответов
answers-twice = ответов повторно
frames-of-others = кадров других устройств
answers-to-nothing = ответов без запроса
collisions = столкновений, нет эха
reconnections = повторных соединений
round-trip = задержка:
trip-last = последняя
trip-average = средняя
trip-min = мин
trip-max = макс

# top/list.rs
list-problems = что не так
column-state = состояние
column-horizontal = гориз.
column-vertical = верт.
column-age = возраст
no-problems = Нет: флаги неисправности не установлены.

# top/scene.rs
scene-no-link = нет связи
scene-no-answer = нет ответа
scene-locked-out = БЛОКИРОВКА
scene-deploying = разворот
scene-paused = пауза
scene-seek = поиск
scene-aligning = юстировка
scene-moving = движение
scene-stowed = свёрнут
scene-deployed = развёрнут
scene-in-between = на полпути
scene-ready = готов

# top/words.rs
scene-stale = устарело
unit-min = мин
unit-h = ч

# aside.rs
lines-left-out = Здесь пропущены строки, которые не успели прочитать: { $count }

# undo.rs
interrupted-while = Прервано: { $words }
risk-barrel = ствол, возможно, ещё движется
risk-program = программа тушения, возможно, ещё выполняется, ствол, возможно, ещё движется
risk-valve-moves = { $valve }: затвор, возможно, ещё движется
risk-drives = { $drives }: привод, возможно, ещё движется
risk-valves-open = { $valves }: затвор, возможно, открыт, вода, возможно, течёт
risk-limits-off = { $drives }: пределы, возможно, ещё выключены
undo-tries =
    { $error }
    { $risk }. До { $seconds } с продолжаются попытки связаться со стволом и послать { $words }; Ctrl-C прекращает их. При опасности сразу нажмите аварийный останов.
stop-tries =
    { $error }
    До { $seconds } с продолжаются попытки связаться со стволом и послать { $words }; Ctrl-C прекращает их. При опасности сразу нажмите аварийный останов.
undo-done = Послано: { $words }; теперь всё в покое.{ $state }
undo-leaves-open = { $valve } не закрыт, вода, возможно, течёт. Чтобы закрыть: lafet close { $name }
undo-not-at-rest = { $words }: ответ получен, но покоя нет: { $state }. { $emergency }
undo-not-seen = { $risk }: покоя после { $words } не видно. { $emergency }{ $why }
undo-gave-up = Попытки прекращены до того, как наступил покой. { $risk }. { $emergency }
use-emergency-stop = Нажмите аварийный останов.

# help/mod.rs: the frame of the help of a command. In English clap has its own words.
heading-usage = Использование:
heading-commands = Команды
heading-arguments = Аргументы
heading-options = Параметры
heading-general-options = Общие параметры
heading-examples = Примеры:
option-help = Показать справку
option-version = Показать версию
usage-options = ПАРАМЕТРЫ
usage-command = КОМАНДА

# help/errors.rs: errors in the arguments. In English clap has its own words.
usage-error = Ошибка: { $what }
usage-error-meant = Ошибка: { $what }. Может быть, `{ $meant }`?
usage-more = Подробнее: lafet --help или lafet КОМАНДА --help
needs-value = для `{ $arg }` нужно значение
value-not-known = неверное значение `{ $value }` для `{ $arg }`; возможны: { $known }
value-wrong = неверное значение `{ $value }` для `{ $arg }`{ $why }
argument-unknown = неизвестный аргумент `{ $arg }`
command-unknown = неизвестная команда `{ $name }`
arguments-conflict = `{ $arg }` нельзя указывать вместе с `{ $other }`
arguments-missing = не хватает аргументов: { $arg }
command-missing = не указана команда
value-too-many = лишнее значение `{ $value }` для `{ $arg }`
value-count = неверное число значений для `{ $arg }`
equals-missing = после `{ $arg }` нужен знак =
argument-not-utf8 = аргумент не в кодировке UTF-8
reason-range = : допустимо { $range }
reason-integer = : ожидается целое число, в допустимых пределах
reason-number = : ожидается число
map-no-server = В { $file } нет такого [[modbus_server]].

# installed/
install-head = { $file }, от имени пользователя { $user }
install-as-root = Выполните проверку от имени root: sudo lafet doctor --install
install-user-missing = На этой машине нет пользователя { $user }.
install-user-missing-remedy = adduser --system --group --no-create-home --home /var/lib/lafet { $user }; либо укажите в --user, от чьего имени работает сервер объекта
install-config-missing = Нет файла конфигурации { $file }.
install-config-missing-remedy = lafet serve --example > { $file }, затем внесите в него стволы объекта.
install-config-denied = Пользователю { $user } нельзя читать { $file }.
install-config-denied-remedy = chgrp { $user } { $file } && chmod 0640 { $file }; папки выше тоже должны пропускать этого пользователя.
install-config-writable = Изменить { $file } могут не только root и пользователь сервера.
install-config-wrong-remedy = Исправьте файл. Оставшиеся ошибки покажет lafet serve --config { $file } --check.
install-state = Папка { $folder } доступна только серверу объекта, и эта версия может с ней работать.
install-state-new = Папки { $folder } ещё нет; она появится при первом запуске.
install-state-denied = Папки { $folder } нет, и пользователь { $user } не может её создать.
install-state-owner = { $path } не принадлежит пользователю { $user }: сервер не сможет туда писать.
install-state-open = Другие пользователи могут читать папку { $folder }, где учётные записи и журнал аудита.
install-state-newer-remedy = Установите более новую версию обратно.
install-group = Пользователь { $user } не входит в группу { $group }, которой доступны последовательные порты.
install-group-remedy = usermod -aG { $group } { $user }, затем перезапустите сервер объекта.
install-ports = Последовательных портов в конфигурации: { $count }; все на месте и доступны серверу.
install-ports-remedy = Список портов показывает lafet ports. Имя из /dev/serial/by-id или /dev/lafet после перезапуска не меняется.
install-port-denied = Пользователю { $user } нельзя открыть { $port }: порт для группы { $group }.
install-port-busy = { $port } занят программой { $program } (процесс { $pid }).
install-port-busy-remedy = Остановите эту программу. ModemManager сам занимает новые порты: systemctl disable --now ModemManager
install-running = Сервер объекта работает; его адрес { $listen }.
install-listen-taken = Адрес { $listen } занят другой программой.
install-listen-taken-remedy = Найдите её командой ss -ltnp и остановите либо задайте другой адрес: listen в [server].
install-listen-denied = Этому пользователю нельзя занять { $listen }.
install-listen-denied-remedy = При запуске через systemd это разрешено: CAP_NET_BIND_SERVICE. Иначе выберите порт больше 1023.
install-listen-wrong-remedy = Задайте адрес этой машины: listen в [server].
install-unit-active = { $unit } работает и запустится вместе с машиной.
install-unit-missing = systemd не знает { $unit }: после отключения питания сервер сам не запустится.
install-unit-disabled = { $unit } не включён: после отключения питания сервер сам не запустится.
install-unit-failed = Служба { $unit } завершилась с ошибкой.
install-unit-stopped = { $unit } не работает.
install-unit-masked = { $unit } замаскирован: запустить его нельзя, и после отключения питания сервер сам не запустится.
install-program-old = { $unit } выполняет программу, которая была до обновления; новая заработает со следующего запуска.
install-recordings-denied = { $user } не может писать в { $folder }, где должны быть записи.
install-clock = Часы этой машины не синхронизированы: время в журнале аудита и в истории не точнее их.
install-clock-remedy = timedatectl set-ntp true; нужен сервер времени, доступный этой машине.

# word.rs
no-random-bytes = система не даёт случайных байтов

# version.rs
version-commit = коммит
version-target = платформа
version-profile = профиль
version-features = в составе
version-allocator = распределитель памяти
version-none = без дополнений
version-system = системный
version-unknown = неизвестен

site-answered = { $question } — { $answer } (из файла)
site-hint-yes-no = [д да, н нет, п пропустить, стоп — закончить]
site-hint-degrees = [градусы, п пропустить, стоп — закончить]
site-hint-pressure = [0,1 атм, п пропустить, стоп — закончить]
site-file-too-long = { $shown } больше { $most } МиБ: это не проект, ответы, ключ или протокол объекта
site-hint-name = [{ $names }, н никакой, п пропустить, стоп — закончить]
site-bad-url = { $url } — не адрес сервера: укажите http://УЗЕЛ:8480 или https://УЗЕЛ:8480
site-bad-ca = в { $file } нет пригодного сертификата: { $error }
site-not-done = ствол не подтвердил, что всё выполнено
site-lost = нет связи с { $url }: { $error }. Работает ли сервер, верен ли адрес?
site-counts = норма { $passed }, ОТКАЗ { $failed }, не проверено { $not_tried }
site-signed = подписано ключом { $public }
site-bad-key = в { $shown } нет ключа: 64 шестнадцатеричные цифры, например из: openssl rand -hex 32
site-key-alone = --key подписывает протокол: добавьте --record или --records.
site-no-signature = в { $shown } нет подписи: ed25519, открытый ключ, подпись
site-verified = { $shown } соответствует подписи ключом { $public }
site-not-verified = { $shown } НЕ СООТВЕТСТВУЕТ ПОДПИСИ, или ключ не тот, что задан; в подписи указан { $public }
site-too-many = в { $shown } больше { $most } протоколов. Перенесите старые в другую папку.
site-no-calendar = В проекте нет календаря: добавьте, например, [calendar] с read_days = 1, dry_days = 7 и outlet_days = 365.
site-every = раз в { $days } сут
site-due = срок { $date }
site-due-now = ПОРА
site-never = никогда
