## Имитатор: занятия и их рисунки, дальность струи.

verdict-passed = ВЫПОЛНЕНО: { $held } из { $all }
fire-news = очаг { $fire } { $what }
link-news = { $monitor }: { $interface } { $what }
address-taken = адрес уже занят: { $monitor }
no-toml = файл не читается как TOML: { $message }
missing = не хватает: { $what }
numbers = { $count } числа: [1, 2.5]
interface-lost = { $interface } потеряна
interface-answers-lost = { $interface }: ответы теряются
request-by-radio = { $request } (радио)
outside-law = { $what } { $value } { $unit }: закон действует от { $least } до { $most } { $unit }
unit-degree = °

too-late = слишком поздно
never-came = до этого не дошло

fire-unknown = `{ $condition }`: имени `{ $name }` нет; есть: { $known }
monitor-unknown = `{ $condition }`: имени `{ $name }` нет; есть: { $known }
condition-missing = не хватает условия
condition-not-understood = условие непонятно: { $error } (как писать условия: docs/scenarios.ru.md)

needs-monitor = нужен хотя бы один [[monitor]]
needs-scenario = нет [scenario]
monitors-at-most = не более { $most } стволов
fires-at-most = не более { $most } очагов
drains-between = от 10 с до 1 ч
only-tank = только резервуар
fire-at-or-on = at = [x, y] или on = "резервуар"
name-without-blanks = имя без пробелов
name-exists = `{ $name }` уже есть
set-refused = на `{ $line }` ствол отвечает { $status }
no-request = `{ $request }` — не запрос: { $error }

a-number = число, { $what }
a-whole-number = целое число, { $what }
empty-list = пустой список ничего не меняет: уберите его
true-or-false = true или false
text-in-quotes = текст в кавычках
text-or-texts = текст или список текстов
a-table = таблица: {"{"} … {"}"}
tables = таблицы: { $form }
word-unknown = `{ $word }` здесь не подходит; допустимо: { $known }
no-time = `{ $text }` — не время: пишите 500ms, 20s или 1.5min

fault-injected = { $name }: неисправность { $fault }
fault-repaired = { $name }: { $fault } устранено
all-repaired = { $name }: всё устранено
wind-from = ветер с { $from }°, { $speed } м/с
air-temperature = температура воздуха { $celsius } °C
fire-ignited = { $name } подожжён
link-back = восстановлена
link-lost = потеряна
link-loses-answers = теряет ответы
power-back = { $name }: питание подано
power-cut = { $name }: питание снято
button-pressed = { $name }: нажата { $post } { $button }
button-released = { $name }: отпущена { $post } { $button }
supply-at = { $name }: давление { $percent } %
fire-burns = горит
fire-hit = достигнут водой
fire-out = потушен
fire-reignited = воспламенился повторно
interface-radio = радиосвязь
interface-wired = проводная связь

two-places = не меньше двух точек

controller-looks-again = автомат: очагов нет, повторный поиск
controller-nothing-burns = автомат: горения больше нет

no-power = нет питания
pump-at = { $name }: насос { $percent } %

no-answer = нет ответа

needs-expect = нужно хотя бы одно [[expect]]: сценарий без ожиданий ничего не проверяет
which-monitor = какой ствол? Один из: { $known }
needs-trigger = нужно at, when или after
needs-action = здесь ничего не происходит; укажите одно из: inject, clear, wind, gusts, wind_from, temperature, ignite, radio, external, power, press, release, supply
a-button = кнопка: { $known }
needs-expectation = нужно одно из: that, never, always
no-effect-without = ничего не меняет без { $what }
no-effect-beside = ничего не меняет рядом с { $what }
after-the-end = этого не будет: сценарий кончается в { $end }
waits-for-itself = ждёт само себя: этого не будет
nothing-to-undo = нечего отменять: ни одно событие сценария не делает обратного для { $monitor }
supply-unused = ни один ствол не питается отсюда
no-unit-there = ничего не меняет: у { $monitor } это не удалённый блок
monitor-lacks = ничего не меняет: у { $monitor } нет { $subsystem }
never-answered = ничего не меняет: запрос, который повторяется до ответа, без ответа не остаётся

heading-time = Время
heading-events = Ход событий
heading-monitors = Стволы
heading-fires = Очаги
heading-expectations = Ожидания
verdict-failed = НЕ ВЫПОЛНЕНО: { $failed } из { $all }
monitor-figures = {" "} { $monitor }: вода { $litres } л за { $seconds } с, впервые { $first }, до { $most_atm } атм; поворот { $turned }°, подъём и опускание { $raised }°; запросов послано/принято/отклонено/без ответа { $counts }; предупреждений { $warnings }, перезапусков { $restarts }
fire-never-burned = {" "} { $fire }: не загорался
fire-figures = {" "} { $fire }: горел с { $lit }, вода достигла { $hit }, потушен { $out }; повторных воспламенений { $reignited }, до { $size_m } м в поперечнике

jet-begins = струя пошла
jet-ends = струя прекратилась
water-in-folded-barrel = ВОДА В СВЁРНУТОМ СТВОЛЕ
program-starts = программа запускается
request-without-answer = { $monitor }: { $request } → нет ответа
turn-never-came = до неё не дошла очередь

picture-passed = ✓ выполнено: { $all } из { $all }
picture-failed = ✗ не выполнено: { $failed } из { $all }
picture-run = { $duration } мин, seed { $seed }

plan-never-burned = не загорался
plan-out = потушен
plan-burns = ГОРИТ
unit-m = м
north = С
indoors = в здании
calm = штиль
unit-mps = м/с
gusts = порывы { $most }

heading-plan = На плане
all-answered-as-expected = на все { $all } запросов даны ожидаемые ответы
monitor-water = { $monitor }: { $litres } л за { $seconds } с, вода с { $first }
monitor-no-water = { $monitor }: без воды
legend-depth = выпало воды, л/м²
legend-dotted = точками: пределы по азимуту, дальность струи в безветрие
legend-circle = круг очага: залит — горит, бледный — потушен; пунктир — наибольший размер

azimuth = азимут
chart-elevation = возвышение
pressure = давление
unit-atm = атм
flow = расход
unit-lps = л/с
heat = мощность очагов
unit-mw = МВт
chart-nozzle = насадок
unit-mm = мм
deployer = развёртывание
vertical-drive = привод по вертикали
time-axis = мин:с
bar-cause = отказ
log-flag = { $subsystem } { $flag }: { $meaning }
bar-flag = флаг

unit-mpa = МПа
outlet = выходное отверстие
nozzle-position = положение насадка
smooth-bore-has-no-spray = гладкий насадок не даёт распылённой струи: не задавайте положение насадка
elevation = возвышение
height = высота
wind = ветер
wind-direction = направление ветра
note-pressure = Опубликованных данных для такого давления и отверстия нет: интервал экстраполирован.
note-elevation = Данные известны только для возвышений 20–45°: интервал экстраполирован.
note-monitor = Середину и высоту струи лафетных стволов не указывает ни один источник: их интервалы взяты от гладких насадков и расширены на интервал наибольшей дальности.
note-spray = Данных о распылённых струях нет: интервал расширен на долю, выбранную нами.
note-wind = Данных о струях на ветру нет: интервал расширен на треть влияния ветра (выбрано нами).

# Что не так с очагом, источником света или стеной в одной строке: az=30,range=25.
given-unnamed = `{ $field }`: ожидается имя=значение
given-unknown = `{ $name }`: известны { $known }
given-no-number = `{ $field }`: `{ $value }` — не число
given-too-little = `{ $field }`: не меньше { $least }
given-outside = `{ $name }={ $value }`: от { $least } до { $most }
given-direction = `{ $field }`: от -360 до 360 градусов
given-class = `{ $field }`: solid или hydrocarbon
given-needed = нужно { $name }=
given-no-place = нужны az= и range=

# Что не так с условием сценария.
word-none-of = `{ $word }` — не одно из { $known }{ $meant }
flag-unknown = `{ $name }` — не флаг { $subsystem }{ $meant }
or-meant = ; может быть, `{ $name }`?
flag-has-no-states = у `{ $flag }` подсистемы { $subsystem } нет состояний: уберите `={ $state }`
condition-form = `{ $condition }`: ожидается ПУТЬ ОПЕРАЦИЯ ЗНАЧЕНИЕ
none-is-alone = `none` стоит одно, после = или !=
path-leads-nowhere = `{ $path }` здесь никуда не ведёт
condition-number = `{ $wanted }`: здесь ожидается число
condition-word = `{ $word }` — слово: подходят только = и !=
condition-flags = флаги: подходят только has, lacks, = и !=
condition-words = `{ $path }`: слишком много слов
fire-has = `{ $what }`: бывает heat, size, density, covered, heated, burning, out, unlit

# Что ожидается в строке испытательного сценария и что пришло.
failure-expected = { $file }:{ $line }: ожидается { $expected }
failure-came = пришло { $came }
line-first = настройка или `case` перед первым случаем
line-answer = `<` сразу после `>`
line-needs-answer = `<` с ответом (или `!` для подготовки)
line-early-end = `never` или `always` перед их `end`
line-nothing-to-end = заканчивать нечего
line-checks = случай, который что-то проверяет
line-nothing = ничего
line-number = число
line-two-numbers = два числа
line-profile = имя профиля
line-address = адрес
line-milliseconds = миллисекунды
line-drive = привод
line-one-of = одно из: { $known }
line-source = external или radio
line-until = `until УСЛОВИЕ within ВРЕМЯ`
line-button = пост и кнопка: `press buttons left`
line-fault = имя неисправности
line-power = power cycle или power cut N old|new|mixed|random|unstable: на слове после N других
line-crash = одно слово `crash`
line-damage = номер хранимого значения
line-word = строка случая ({ $known })
line-hex = шестнадцатеричное число, а не `{ $word }`
line-time = время: 500ms или 2.5s
line-hour = не больше часа
run-stored-value = хранимое значение { $key }
run-nothing-stored = там ничего не хранится
run-no-answer = ответов больше нет
run-answer-after = `{ $wanted }` после `{ $asked }`
run-none-after = больше никакого ответа после `{ $asked }`
run-taken = `{ $asked }` должно быть принято
run-within = { $condition } за { $ms } мс
