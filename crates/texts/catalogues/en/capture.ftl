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

# read.rs: why a file is not read.
not-a-recording = neither an MCAP nor a pcapng recording. `lafet record` makes them; raw bytes are for `lafet decode`
recording-of-network = a recording of a network, not of a line: open it in Wireshark with the dissector (`lafet dissector`)
recording-without-frames = an MCAP file without the frames that lafet records
recording-too-large = more than { $most } MiB unpacked
recording-damaged = damaged: { $why }
recording-unreadable = cannot be read: { $error }
