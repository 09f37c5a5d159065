## Что можно сломать в имитаторе.

drive-motor-open = обрыв цепи двигателя
drive-jam = заклинило
drive-power-stage = силовой каскад не работает, и диагностики нет
drive-runaway = силовой каскад пробит: вращается на полной скорости с управлением и без него
drive-friction = сильное трение: ток больше допустимого
drive-flicker = сильное трение, и показания тока временами пропадают
drive-lag = скорость отстаёт от заданной
drive-dead-band = на малой скорости не вращается
drive-droop = нагрузка снижает скорость
drive-backlash = люфт в передаче
drive-stiff = густая смазка: ток больше обычного
drive-encoder-dead = показания положения не меняются
drive-encoder-reversed = положение считается в обратную сторону
drive-encoder-fast = положение считается вчетверо быстрее
drive-encoder-jump = показание положения скачком изменилось
drive-encoder-noise = показания положения с шумом
drive-encoder-fault = датчик положения сообщает о неисправности
drive-speed-dead = датчик скорости показывает 0
drive-speed-reversed = у датчика скорости обратный знак
drive-speed-fault = датчик скорости сообщает о неисправности
drive-min-switch = выключатель нижнего, правого, широкого или дежурного положения залип
drive-max-switch = выключатель верхнего, левого, узкого или рабочего положения залип
drive-min-bounce = выключатель нижнего, правого, широкого или дежурного положения дребезжит
drive-max-bounce = выключатель верхнего, левого, узкого или рабочего положения дребезжит

valve-motor-open = обрыв цепи двигателя
valve-open-relay = реле открытия залипло: открывается с управлением и без него
valve-jam = заклинило
valve-open-switch = обрыв или замыкание цепи выключателя «открыт»
valve-close-switch = обрыв или замыкание цепи выключателя «закрыт»
valve-close-stuck = выключатель «закрыт» залип
valve-blocked = включена аппаратная блокировка
valve-open-bounce = выключатель «открыт» дребезжит
valve-close-bounce = выключатель «закрыт» дребезжит
valve-blocked-bounce = контакт аппаратной блокировки дребезжит

unit-offline = удалённый блок не отвечает
unit-lossy = половина обменов с удалённым блоком теряется
unit-protocol = удалённый блок нарушает протокол внутренней магистрали
unit-watchdog = удалённый блок перезапущен сторожевым таймером
unit-param-silent = удалённый блок не отвечает на обращения к параметрам
unit-param-incomplete = обращения к параметрам удалённого блока: RemotePaIncomplete
unit-param-bad-id = обращения к параметрам удалённого блока: RemotePaBadId
unit-param-bad-value = обращения к параметрам удалённого блока: RemotePaBadVal
unit-param-error = обращения к параметрам удалённого блока: RemotePaError

place-temperature = датчик температуры не отвечает
place-temperature-frozen = показания датчика температуры не меняются
place-temperature-drift = показания датчика температуры уходят на 0,1 °C в секунду
place-heater = обрыв цепи нагревателя

button-short = короткое замыкание
button-break = обрыв провода
button-bounce = контакт дребезжит

single-pressure-break = Датчик давления: обрыв цепи, 0 мА
single-pressure-short = Датчик давления: замыкание цепи, 28 мА
single-pressure-frozen = Датчик давления: показания не меняются
single-pressure-drift = Датчик давления: показания уходят на 20 мкА в секунду
single-flow-frozen = Расходомер: показания не меняются
single-flow-drift = Расходомер: показания уходят на 1 л/с за пять секунд
single-pump-off = Насос: давления нет
single-pump-weak = Насос: четверть давления
single-voltage-low = Питание: на треть ниже нормы
single-voltage-high = Питание: на треть выше нормы
single-supply-dip = Питание: проседает на 200 мс при пуске двигателя
single-supply-sag = Питание: проседает, пока работает двигатель
single-humidity = Датчик влажности: не отвечает
single-detector-dead = Извещатель: не отвечает
single-detector-saturated = Извещатель: засвечен, куда бы ни смотрел
single-dirty-lens = Извещатель: стекло загрязнено
single-flash-read = Память: чтение не удаётся
single-flash-write = Память: запись не удаётся
