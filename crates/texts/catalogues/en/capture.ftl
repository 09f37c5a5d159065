## Texts of the dissector for Wireshark.

protocol = Fire monitor
protocol-records = Fire monitor, bare records
tcp-ports = TCP ports of monitors
udp-ports = UDP ports of monitors
dst = Receiver
src = Sender
kind = Kind
probe = presence probe
request = request
answer = answer
noise = Bytes outside frames
record = Record
device = Subsystem
status = Status
size = Size of the data
data = Data
bad-crc = The CRC is wrong
bad-escape = DB is followed by neither DC nor DD
cut = record cut short
unescaped = Unescaped frame
shape = Data of an unexpected size
refused = Refused
