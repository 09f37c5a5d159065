## Контроллер зон: отказы, почему нет пуска, неисправности, конфигурация.

refusal-lockout = Включена аварийная блокировка. Сначала снимите её.
refusal-off = Зона отключена. Сначала задайте другой режим.
refusal-abort-pressed = Нажат контакт отмены пуска. Сначала отпустите его.
refusal-just-refused = Одновременно пришли Stop, Close, отмена или блокировка. Повторите через 2 с.
refusal-released = В зоне выполнен пуск. Сначала прекратите его.
refusal-too-late = Поздно: пуск уже выполнен. Его прекращает отмена.
refusal-no-hold = Удержание в этой зоне не предусмотрено.
refusal-unknown = Такого имени в конфигурации нет.
refusal-range = Значение вне диапазона: испытание длится от 1 до 3600 с, другой режим — от 1 до 604800 с; испытание выпуска требует испытательного выпуска.
refusal-still-pressed = Ещё нажат контакт с противоположным действием.

not-released-lockout = включена аварийная блокировка
not-released-abort-pressed = нажата отмена пуска
not-released-stop-pressed = нажат контакт остановки
not-released-ended = пуск прекращён; выполните сброс зоны
not-released-mode = зона не в автоматическом режиме
not-released-votes = голосов { $have } из { $need }
not-released-kinds = голоса извещателей одного вида
not-released-failed = отказало слишком много извещателей
not-released-stale = тревога, существовавшая при запуске, голоса не имеет
not-released-coincidence = голоса должны совпадать дольше
not-released-delay = идёт задержка
not-released-held = задержка удерживается
not-released-no-monitor = зону не может обслужить ни один ствол
trouble-detector-fault = неисправность извещателя
trouble-detector-silent = извещатель не отвечает
trouble-detector-dirty = загрязнено окно извещателя
trouble-detector-stuck = самопроверка извещателя не заканчивается
trouble-path = неисправность линии
trouble-contact-stuck = контакт залип: пуск был нажат при первом опросе либо задержка нажата ещё до тревоги или слишком долго
trouble-monitor-unreachable = ствол не отвечает
trouble-monitor-failure = отказ ствола
trouble-monitor-idle = ствол не выполняет команду
trouble-not-closed = нет подтверждения закрытия затвора
trouble-output-overdue = нет подтверждения выхода
trouble-pump-overdue = выполнение команды насосом не подтверждено
trouble-pump-failed = насос не создаёт давления
trouble-no-pressure = ни один насос не создаёт давления
trouble-no-monitor = нет ствола для зоны с пуском
trouble-few-jets = в зоне работает меньше стволов, чем нужно

out-of-range = { $key } = { $value } вне диапазона.
out-of-range-remedy = Укажите от { $least } до { $most }.
not-configured = { $key }: `{ $name }` не описан.
not-configured-remedy = Исправьте имя или добавьте описание.
named-twice = { $key }: `{ $name }` указан дважды.
named-twice-remedy = Укажите его один раз.
id-length = Имя `{ $id }` пустое, слишком длинное или из одних точек.
id-length-remedy = Укажите от 1 до { $most } символов, не одни точки.
id-twice = Имя использовано дважды.
id-twice-remedy = Дайте каждому своё имя.
too-many = { $count } — слишком много.
too-many-remedy = Не более { $most }; разделите объект.
detector-without-zone = Не указана зона: тревога нигде не будет показана.
detector-without-zone-remedy = Укажите зону в `zones`.
starts-in-test = Зона не может начинать работу с испытания.
starts-in-test-remedy = Укажите automatic, manual или off.
votes-impossible = votes = { $votes }: голосов не нужно или нужно больше, чем есть.
votes-impossible-remedy = Укажите, например, 2oo3.
votes-not-of-detectors = votes = { $votes }, но в зоне извещателей: { $count }.
votes-not-of-detectors-remedy = Укажите …oo{ $count } или исправьте `zones` извещателей.
one-vote-releases = Один извещатель сам подал бы воду.
one-vote-releases-remedy = Потребуйте два голоса или укажите one_detector_releases = true.
kinds-impossible = kinds = { $needed } невыполнимо: { $votes }, видов: { $kinds }.
kinds-impossible-remedy = Укажите от 1 до числа голосов и видов в зоне.
reduced-not-fitting = when_failed: { $votes } не подходит к { $failed } отказавшим из { $of }.
reduced-not-fitting-remedy = Укажите …oo{ $left } не менее чем с { $kinds } голосами или "alarm".
reduced-to-one = when_failed: при { $failed } отказавших воду подал бы один извещатель.
reduced-to-one-remedy = Укажите "alarm" или one_detector_releases = true.
no-monitor = Зону не обслуживает ни один ствол.
no-monitor-remedy = Укажите стволы в `monitors`.
jets-impossible = jets = { $jets }, а стволов: { $monitors }.
jets-impossible-remedy = Укажите от 1 до числа её стволов.
valve-used-twice = Клапан `{ $output }` использован несколько раз.
valve-used-twice-remedy = Дайте каждой зоне и каждому испытательному выпуску свой клапан.
contact-of-whole-site = Блокировка и давление относятся ко всему объекту.
contact-of-whole-site-remedy = Удалите `zones`.
station-without-zones = Пост пуска без зон дал бы пуск на всём объекте.
station-without-zones-remedy = Укажите его зоны.
valve-unused = Этот клапан не использует ни одна зона.
valve-unused-remedy = Укажите его в `valve` или `test_outlet` зоны.
all-standby = Все насосы резервные: ни один не запустился бы.
all-standby-remedy = Уберите `standby` у одного из них.

stored-version = Версия сохранённого состояния { $found }, а не { $wanted }.
stored-version-remedy = Запустите записавшую его программу или подтвердите потерю и задайте режимы и отключения заново.
