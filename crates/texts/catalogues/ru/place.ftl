## Отказы расчёта расположения. Названия величин и предметов подставляются в `out-of-range` и `too-many`.

out-of-range = { $what }: { $value }; допустимо: { $least } … { $most }
too-many = { $what }: { $count }; допустимо: { $least } … { $most }

supply-flow = расход, л/мин
curve-points = точек кривой
curve-flow = расход на кривой, л/мин
curve-pressure = давление на кривой, МПа
curve-not-falling = кривая начинается с расхода 0; от точки к точке расход растёт, а давление не растёт

probability = вероятность
stations = станций
bearings = пеленгов
floor-height = высота пола, м
sights-parallel = линии визирования не пересекаются либо почти параллельны: нужны пеленги двух станций, которые видят очаг с разных сторон
bearings-apart = пеленги не сходятся в одном месте: очагов несколько либо один из пеленгов ошибочен, и определить какой нельзя

area-corner = угол участка, м
area-extent = размер участка, м
cell-side = сторона ячейки, м
plane-height = высота защищаемой плоскости, м
too-many-cells = { $cells } ячеек; допустимо { $most }. Увеличьте ячейку или уменьшите участок
winds = ветров
flowing-monitors = одновременно работающих стволов

fires = очагов
monitor-states = состояний стволов
barrel-direction = положение ствола, рад

fire-place = место очага, м
fire-area = площадь очага, м²
fire-density = интенсивность для очага, л/(мин·м²)

reference-fires = контрольных очагов
reference-place = место контрольного очага, м
reference-distance = расстояние до контрольного очага, м
reference-without-elevation = контрольный очаг без угла места: наклон не определить
references-weak = по этим контрольным очагам курс и наклон не определить: нужно не менее пяти, от первого до последнего не менее 40°, на разных расстояниях
alignment-unsettled = юстировка не сходится: проверьте места контрольных очагов и их порядок
reference-wrong = контрольный очаг { $number } не согласуется с остальными: по азимуту { $azimuth }°, по углу места { $elevation }°; проверьте его место и не перепутаны ли два очага

box-heading = курс параллелепипеда, рад
body-coordinate = координата тела, м
body-size = размер тела, м
body-height = высота тела, м

station-place = место станции, м
station-heading = курс станции, рад
station-tilt = наклон станции, рад
station-angle-error = погрешность углов станции, рад
station-height-error = погрешность высоты станции, м
station-unknown = пеленг станции { $station }; всего станций: { $stations }
azimuth = азимут, рад
elevation = угол места, рад
bearing-error = погрешность пеленга, рад
bearing-quality = качество пеленга
bearing-age = возраст пеленга, мс

monitor-place = место ствола, м
nozzle-height = высота насадка, м
monitor-heading = курс ствола, рад
azimuth-limit = предел горизонтали, рад
elevation-limit = предел вертикали, рад
limits-reversed = пределы ствола: первый меньше второго
outlet = диаметр выхода, мм
nozzle-position = положение насадка, мм
flow-at-1-mpa = расход при 1 МПа, л/мин
drive-speed = скорость привода, рад/с
sector-of-unknown-monitor = запретный сектор несуществующего ствола
sector-angle = угол сектора, рад
wind-direction = направление ветра, рад
wind-speed = скорость ветра, м/с
monitors = стволов
obstacles = препятствий
keep-outs = запретных секторов
monitor-clearance = расстояние до стволов, м

rectangle-skew = стороны прямоугольника не перпендикулярны
disc-radius = радиус круга, м
surface-coordinate = координата поверхности, м
normal-length = длина нормали
surfaces = поверхностей
one-station-needs-elevation = одной станции для определения места нужен угол места
sight-meets-nothing = линия визирования не встречает ни одной поверхности
sight-too-flat = линия визирования почти параллельна поверхности: место не определить
