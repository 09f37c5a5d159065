## Разборщик для Wireshark.

protocol = Лафетный ствол
protocol-records = Лафетный ствол, записи без кадров
tcp-ports = Порты TCP стволов
udp-ports = Порты UDP стволов
dst = Получатель
src = Отправитель
kind = Вид
probe = проба присутствия
request = запрос
answer = ответ
noise = Байты вне кадров
record = Запись
device = Подсистема
status = Статус
size = Размер данных
data = Данные
bad-crc = Неверная CRC
bad-escape = После DB не DC и не DD
cut = запись оборвана
unescaped = Кадр без экранирования
shape = Неожиданный размер данных
refused = Отказ

# read.rs: why a file is not read.
not-a-recording = не запись MCAP и не pcapng. Их делает `lafet record`; сырые байты — для `lafet decode`
recording-of-network = запись сети, а не линии: откройте её в Wireshark с разборщиком (`lafet dissector`)
recording-without-frames = файл MCAP без кадров, которые пишет `lafet record`
recording-too-large = в распакованном виде больше { $most } МиБ
recording-damaged = повреждён: { $why }
recording-unreadable = не читается: { $error }
