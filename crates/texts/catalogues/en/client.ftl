## What the client says: errors, refusals, what to do about them, the diagnosis of a link.

# error.rs: why a request failed.
refused = { $request } { $to }: { $by } answers { $status }. { $why } { $remedy }
no-answer-but-stray = { $request } { $to }: no answer from { $endpoint } (tries: { $tries }). What came answers { $stray }, which was not asked: another program uses this connection, or the monitor's program does not follow the protocol.
no-answer = { $request } { $to }: no answer from { $endpoint } (tries: { $tries }). Check the power, the cable, the address (addr=) and, on a serial line, the speed (baud=).
absent = No device answers at { $endpoint } (probes: { $tries }). Check the power, the cable, the address (addr=) and, on a serial line, the speed (baud=).
not-probed = Nothing was sent to { $endpoint }, because { $cause }.
outcome-unknown = { $request } { $to }: sent to { $endpoint }, but { $cause }. It may have been executed. { $check }
not-sent = { $request } { $to }: not sent, because { $cause }. Nothing was executed: repeat it if it is still wanted.
cannot-switch-direction = { $endpoint }: the driver of this port cannot switch the direction of RS-485 by RTS ({ $source }). Leave out rs485= if the adapter does it by itself, as most on USB do.
no-connection = No connection to { $endpoint }: { $source }. Check that the monitor is on and that host, port or device are right.
breaks-protocol = { $request } { $from }: the monitor answered, but not what the protocol says: { $what }. The monitor's program does not follow the protocol: note it and report it.
too-long = { $request } { $to }: more than a request can carry (255 bytes of data, 63 values). Send fewer values.
not-a-read = { $request } { $to } changes something, so it cannot be asked again and again. Subscribe to a request that reads.
address-impossible = { $endpoint }: { $address } is no address of another device there. Monitors have 1…127; bare records (framing=records) lead to one monitor only.
needs-stream = sim: needs a simulator in this process. Give the client its stream, or start `lafet sim` and connect to the address it prints.
closed = The client has been shut down. Make a new one.

# Why nothing was sent, or what came instead of an answer: a clause in the sentences above.
cause-silence = no answer came
cause-odd-answer = the answer of { $from } is not what the protocol says: { $what }
cause-no-connection = there is no connection ({ $source })
cause-superseded = { $by } overtook it
cause-queue-full = too many requests are waiting
cause-expired = its time was over before its turn came
cause-earlier-failed = another request of the batch failed
cause-check-missing = the monitor answers frames with a CRC-16 only (use check=auto)
cause-no-controller = there is no controller on the bus to give access (use role=direct)
cause-not-granted = the controller of the bus gives this address no access (is src= one that it looks for, and no other device's?)
cause-unreadable = bytes that are no frames arrive on the line: devices at another speed, or noise (is baud= right? insist=1 sends all the same)
cause-controller-present = there is a controller on the bus (use role=active, and a src= of your own)

# deviation.rs: how an answer breaks the protocol; a clause without a full stop.
odd-shape = its data have the wrong size or form ({ $error })
odd-no-data = it reports success, but has no data
odd-status = { $status } is no status of the protocol
odd-other-parameter = parameter { $asked } was asked for, the answer is about { $answered }
odd-other-request = it answers { $answered }
odd-other-subsystem = { $asked } was asked, and { $answered } may not answer for it
odd-no-subsystem = its sender, { $answered }, is no subsystem of a monitor
odd-count = it has { $answered } records for { $asked } requests

# port_error.rs: why a serial port cannot be opened.
port-in-use = { $port } is in use by { $by }. Close that program, or write shared=1 into the URL of both: then each may lose answers to the other.
another-program = another program
program-with-id = { $program } ({ $pid })
port-not-permitted = No permission to open { $port }. Join the group { $group } (`sudo usermod -aG { $group } $USER`), then log in again.
port-of-owner = No permission to open { $port }: its owner can grant it.
port-missing = There is no port { $port }. Check that the adapter is plugged in; `lafet ports` lists the ports that there are.
port-without-door = { $port } is not listened to: a Stop of another program could not ask for it meanwhile ({ $error }). The system has no socket left for this program: close others, or raise the limit of open files (`ulimit -n`).
port-other-adapter = { $port } is another adapter now: { $now } in place of { $was }. Nothing is sent to it: another monitor may be there. Plug the former adapter in again; a path in /dev/serial/by-id names an adapter, not a socket (`lafet ports`).
port-not-serial = { $port } is not a serial port, or there is no hardware behind it. `lafet ports` lists the ports that there are.

# os_text.rs: errors of the system. In English the system words them itself.
os-not-found = no such file, device or host
os-not-permitted = permission denied
os-refused = connection refused
os-reset = connection reset by the other side
os-aborted = connection aborted
os-not-connected = no connection
os-host-unreachable = host unreachable
os-network-unreachable = network unreachable
os-network-down = network down
os-address-in-use = address already in use
os-address-not-here = this computer has no such address
os-broken-pipe = the other side has closed the connection
os-exists = already exists
os-timed-out = timed out
os-unexpected-end = the data ended too early
os-disk-full = no space left on the disk
os-read-only = read-only file system
os-is-folder = a folder, not a file
os-not-folder = not a folder
os-busy = device busy
os-invalid = invalid value
os-too-large = file too large
os-quota = quota exceeded
os-no-utf8 = this is no UTF-8 text
os-host-unknown = this name of a host is not known here: check its spelling and the name server, or write the address ({ $error })
os-other = system error: { $error }
os-numbered = { $what } (system error { $number })

# url_error.rs: errors of a monitor's URL, and the values of its options.
url-syntax = `{ $url }` is not a URL: { $reason }. Write it like { $example }.
url-no-host = empty host
url-host-sign = invalid domain character
url-ipv4 = invalid IPv4 address
url-ipv6 = invalid IPv6 address
url-no-scheme = relative URL without a base
url-scheme = `{ $url }`: `{ $scheme }:` is no way to reach a monitor. Use tcp://, udp://, serial:// or sim:, like { $example }.
url-nowhere = `{ $url }` does not say where to connect. Write it like { $example }.
url-part = `{ $url }`: `{ $part }` has no meaning here. Leave it out.
url-option = There is no option `{ $key }` here. Those there are: { $known }.
url-twice = The option `{ $key }` is given twice. Leave one.
url-value = `{ $key }={ $value }`: { $key } must be { $allowed }.
allowed-monitor-address = an address of a monitor, 1…127
allowed-source-address = the controller's address 128 or a console's, 129…254
allowed-baud = a speed of the line, 300…4000000 (19200 is usual)
allowed-framing = link or records
allowed-port = a number, 1…65535
allowed-rs485 = off, rts or rts-low
allowed-echo = off, strip or verify
allowed-delay = a time in milliseconds, 0…1000
allowed-check = crc16, auto or crc32c
allowed-role = direct or active
allowed-console-address = a console's address, 129…254, with role=active
allowed-late = a time in whole seconds, 0…60
allowed-yes = 0 or 1
allowed-switch = on or off
allowed-with-rs485 = left out unless rs485=rts or rs485=rts-low is given

# backup/file.rs: errors in a file of parameters.
file-no-toml = this is no TOML, line { $line }: { $what }
file-format = this is no file of `lafet param backup`, or one of a later lafet: `format = { $format }` is missing
file-cut = this is only a part of a file: its last line, `{ $end }`, is missing. Take a whole copy
file-unknown = line { $line }: { $name }: the dictionary has no such parameter
file-count = line { $line }: { $title }: { $min } to { $max } whole numbers expected
file-range = line { $line }: { $title }: allowed are { $allowed }
file-read-only = line { $line }: { $title }: cannot be set; remove it from the file

# parse_error_text.rs: what is wrong in the text of a request.
parse-error = column { $column }: { $expected }
parse-error-meant = column { $column }: { $expected }; did you mean `{ $name }`?
expected-request = expected a request (0x and two digits, or one of { $names })
expected-subsystem = expected a subsystem (0x and two digits, or one of { $names })
expected-parameter = expected a parameter of { $subsystem } (0x and four digits, @AnyName)
expected-parameter-of = expected a parameter of { $subsystem } (0x and four digits, @AnyName, or one of { $names })
expected-word = expected { $words }
or = { $one } or { $other }
expected-number = expected { $what }, a number from { $min } to { $max }
expected-numbers = expected { $what }, { $count } numbers with commas between them
missing = { $what } is missing
given-twice = given twice
not-together = { $one } and { $other } belong to different variants of the request
expected-hex = expected bytes in hexadecimal, like `de ad be`
expected-end = expected nothing more
expected-fewer-data = too many data: a request carries 255 bytes at most
request-wrong = the request is wrong

# What a number of a request means.
number-destination = destination
number-start-horizontal = start, horizontal
number-end-horizontal = end, horizontal
number-start-vertical = start, vertical
number-end-vertical = end, vertical
number-value = value
number-key = key
number-program = program
number-nozzle = nozzle
number-step = step
number-distance = distance
number-dwell = dwell
number-horizontal = horizontal
number-vertical = vertical
number-correction = correction
number-corrections = corrections
number-trajectory = trajectory
number-first = first
number-count = count
number-analyse = analyse
number-centre = centre h,v
number-sector = sector width,height
number-point = point h,v,distance,dwell
number-distance-or-corrections = distance= or corrections=
number-point-or-stored = point= or stored=

# outcome_check.rs: how to check whether a request without an answer was executed.
check-move = GetStatus of the drive shows it: Move is set, or the position has changed.
check-stop = Send it again at once; GetStatus All shows when all motion has ended.
check-open = GetStatus of the valve shows it: Opening or Open. In doubt, send Close.
check-close = Send it again at once; GetStatus of the valve shows it: Closing or Closed.
check-deployer = GetStatus Deployer shows it: Deploying, Deployed, Wrapping or Wrapped.
check-parameter = GetParam of the same parameter shows its present value.
check-correction-table = No request reads the table back. Send the same corrections again: that does no harm.
check-justify = GetStatus Detector shows it: Justifying, Justified or DeviceFault.
check-program = GetStatus Control shows it: Quench or Trajectory is set. In doubt, send Stop Control.
check-seek = GetStatus Detector shows it: Searching, Found or Canceled.
check-limits = GetStatus Motors shows it: Limitless is set while limits are off.
check-lockout = GetStatus General shows it: LockedOut is set while the monitor is locked out.
check-restart = GetStatus All shows it: Restarting, or the state after power-up.
check-clean-flash = GetStatus General shows it: ConfigInvalid is set once the memory is empty.
check-other = Read the status before you repeat it.

# refusal.rs: why a request was refused, and what to do.
limits-state-unknown = There is no such state of limits.
limits-state-remedy = Send 0 (off), 1 (on) or 2 (reject).
deploy-first = Deploy it, and wait until GetStatus Deployer says Deployed.
stop-detector = Wait until Searching and Justifying are gone, or send Stop Detector.
stop-control = Wait until the program ends, or send Stop Control.
close-valve = Close the valve, and wait until it says Closed. If it says so already, read InputFaults of General: with bit 0 water flows all the same; close the main by hand.
stop-all = Send Stop to the subsystem that refuses, or Stop All, which is never denied.
read-flags = Read the status of the subsystem: its flags name the fault.
locked-out = The monitor is locked out: only reads and SetParam are done.
locked-out-remedy = Find out who locked it out and why; then release it (Lockout off).
locked-by-update = An update keeps the monitor locked out: an image is on trial, or its commit has not been taken back yet.
locked-by-update-remedy = See `lafet update --state`. Let the update come to its end (the same `lafet update` goes on), or wait until the monitor has gone back, 180 s after its start; then release it (Lockout off).
deployer-moves = The barrel is being deployed or stowed: only Stop Deployer or Stop All ends that.
not-deployed = The barrel is not deployed: it is stowed, moving, or between the positions.
program-or-alignment-runs = An extinguishing program or an alignment is running, or limits are off.
program-or-alignment-remedy = Send Stop Control or Stop Detector; switch the limits on.
search-runs = A search is running: only Stop Detector or Stop All ends it.
search-or-alignment-runs = A search for fire or an alignment is running.
program-without-limits = Limits are off: a program could run the barrel anywhere.
limits-on = Switch the limits on. If a drive is not homed (bits 8 to 10 of InputFaults of General), first move it to the end that its parameter Homing names.
program-only-stopped = An extinguishing program is running: only Stop Control or Stop All ends it.
program-runs = An extinguishing program is running.
water-in-folding-barrel = The valve is not closed, or water flows: in a folding barrel it destroys it.
water-before-detector = The valve is not closed, or water flows: the detector would look into it.
water-under-folding-barrel = The valve is not closed, or water flows: the barrel must not fold under it.
valve-blocked = The valve is blocked by hardware (Blocked): it may be closed, not opened.
valve-blocked-remedy = Set the valve's unit to remote, release the handwheel, check the interlock circuit; a person may be working on the valve. Open is taken again once Blocked is gone.
not-homed = The drive is not homed: its position is not known, and with it its limits.
barrel-not-homed = Horizontal or Vertical is not homed: where the barrel rests is not known.
home-it = Move it to the end that its parameter Homing names; the end switch there stops it. Bits 8 to 10 of InputFaults of General show which drives are not homed.
water-flows = The valve is not closed, or water flows.
locked-out-or-weak = The monitor is locked out, or its supply is out of range: then no motion, water or erasing begins.
locked-out-or-weak-remedy = GetStatus General shows which. LockedOut: find out who locked it out and why, then release it (Lockout off). BadPower: check the supply.
supply-weak = The supply voltage is out of range (BadPower): no motion, water or erasing begins; Stop, Close and Lockout are done.
supply-remedy = Compare main_voltage of General with a meter at the terminals, and with MainVoltageMin and MainVoltageMax; check supply, battery and cable. The request is taken again once BadPower is gone.
button-held = A button of the drive is pressed at the button post: it goes before requests.
release-button = Wait until it is released; the status of Buttons and ExtButtons shows which one it is.
barrel-not-homed-or-water = Horizontal or Vertical is not homed, or water flows and there is no valve to close.
barrel-not-homed-or-water-remedy = Read InputFaults of General: bits 8 to 10 show which drives are to be moved to the end that their parameter Homing names; if water flows, close the main by hand.
deployer-not-free = The barrel is stowed or moves between its positions: Move of Deployer is taken while it is deployed, or at rest between.
deployer-not-free-remedy = Deploy it, or wait until the motion ends.
water-without-valve = Water flows, and the monitor has no valve to close.
close-main = Close the main by hand; if nothing flows, check the flow meter.
search-goes-on = A search for fire is running (Searching).
alignment-goes-on = The detector is being aligned (Justifying).
alignment-runs = The detector is being aligned: only Stop Detector or Stop All ends it.
search-or-alignment-only-stopped = A search or an alignment of the detector is running: only Stop Detector or Stop All ends it.
search-or-no-limits = A search for fire is running, or limits are off.
search-or-no-limits-remedy = Send Stop Detector; switch the limits on.
open-under-folding = The valve is not closed: water in a folding barrel destroys it.
open-before-detector = The valve is not closed: the detector would look into the water.
valve-not-closed = The valve is not closed.
flows-though-closed = Water flows though the valve was closed, or its sensor is faulty (CloseSensorFault): it is not taken as closed.
look-for-water = Look whether water flows: if it does, close the main by hand; if not, check the sensor of the closed position and the flow meter.
close-and-wait = Close the valve, and wait until it says Closed.
subsystem-faulty = The subsystem is faulty, or has stopped this way because of its current.
limits-not-received = The remote unit has not received the new limits yet.
drive-moves = The drive moves: a limit or the zero point is taken only at rest.
monitor-restarts = The monitor is restarting: it answers reads only.
repeat-in-a-second = Repeat the request in a second.
restart-for-all-only = Restart is accepted for All only: a subsystem alone cannot be restarted.
restart-all = Send Restart All.
not-for-broadcast = No subsystem takes this request from a broadcast.
name-subsystem = Name the subsystem you mean.
request-not-supported = The monitor does not support this request.
request-not-supported-remedy = Its program may be older than the request: see what it supports.
request-not-for-subsystem = This request is not provided for this subsystem.
request-not-for-subsystem-remedy = Send it to an addressee of its section in the protocol.
parameter-count = The parameter has another number of values.
table-empty = The table has no entries.
quench-form = The data are neither of the three forms of StartQuench.
points-count = The number of points does not fit the size of the data.
correct-count = Correct the number of values.
trajectory-empty = The stored trajectory is empty.
trajectory-empty-remedy = Store it first, or take another.
parameter-unknown = The subsystem has no parameter with this name.
parameter-unknown-remedy = Check the name letter by letter; another version may have other parameters.
sector-outside-limits = The sector is not wholly inside the limits (BadSector), or analyse is not 0 or 1.
sector-inside-limits = Take a sector inside the limits of Horizontal and Vertical.
quench-sector-outside-limits = The sector is wholly outside the limits, or a number of it is out of range.
quench-sector-remedy = Take a sector that touches the limits of Horizontal and Vertical.
trajectory-out-of-range = A point, a flag or a number of a trajectory is out of range.
trajectory-numbers = Stored trajectories are 0 to 7.
limits-crossed = With the limits taken, the lower one would not be below the upper one.
limits-crossed-remedy = Take the other limit again, or drop both (SwitchLimits reject).
table-too-long = The table has 256 entries, no more.
table-too-long-remedy = Begin earlier or send fewer.
lockout-key = The key is neither of the two of Lockout.
lockout-key-remedy = Send 0x2FFA (on) or 0x7353 (off).
parameter-out-of-range = The value is out of the parameter's range.
parameter-range = See the range of the parameter.
drive-parameter-out-of-range = The value is out of range; or limits are off, and then a limit or the zero point takes the present position only.
drive-parameter-remedy = See the range of the parameter; switch the limits on, or teach the limit.
status-unknown = The protocol has no such status.
status-unknown-remedy = Report it.

# teach.rs: ends of a drive's travel, in a sentence about its limit.
side-left = left
side-right = right
side-up = upper
side-down = lower
side-narrow = narrowest
side-wide = widest

# doctor/examine.rs: what the diagnosis is doing.
doing-open = opening the link
doing-listen = listening
doing-wait-for-access = waiting for access
doing-listen-at-speeds = listening at other speeds
doing-probe = probing
doing-ask = asking
doing-addresses = trying the other addresses
doing-speeds = trying other speeds

# doctor/texts.rs: what was observed.
seen-well = The monitor answers{ $exchange }.
seen-no-link = { $link } cannot be used: { $error }.
seen-nothing = The link is open, but not one byte has come: { $listened_s } s of listening, { $probes } probes to address { $monitor }, probes to all other addresses.
seen-echo = { $frames } frames came back just as they were sent.
seen-no-echo = The URL promises an echo (echo=), and none came.
seen-other-speed = At the speed of the URL nothing can be read{ $sample }; at { $baud } baud it can.
seen-wrong-speed = Probes are answered by { $bytes } bytes that are no frame{ $sample }; without probes the line is quiet.
seen-noise = { $silent }{ $broken } broken frames and { $stray_bytes } bytes that belong to no frame{ $unasked }{ $exchange }.{ $held_back }
noise-silent = The monitor does not answer:{ " " }
noise-unasked = ; { $bytes } bytes came without a request
seen-loss = { $answered } of { $probes } probes were answered{ $exchange }; nothing else was heard.
seen-unanswered = { $answered } of { $probes } probes were answered, but none of { $sent } requests.
seen-other-speakers = Other devices transmit on this line: { $who }. { $frames } of their frames were heard.{ $held_back }
nothing-sent = {" "}So nothing was sent (--insist sends).
seen-address-taken = Frames from or to our own address { $address } were heard that we have not sent or asked for.
seen-odd-answers = The monitor answers GetStatus General, but not as the protocol says: { $odd }.
odd-answers = { $odd } of { $answered } answers{ $records }
odd-without-records = ; the first without records
seen-no-controller = The URL says role=active, and no controller was heard.
seen-no-access = A controller was heard, but it gives no access to our address { $address }.
seen-monitor-silent = The controller gives access, but address { $monitor } does not answer.
seen-wrong-address = Address { $monitor } is silent ({ $probes } probes); these answer: { $others }.
seen-two-with-one-address = One probe to address { $monitor } was answered twice.
seen-crc32c-only = Frames with the usual CRC-16 get no answer, one with a CRC-32C does.
seen-records-answered = Link frames get no answer, a bare record does.
seen-frames-answered = Bare records get no answer, a link frame does.
seen-other-protocol = The device does not use this protocol. It sent: `{ $text }`
exchange-result = ; { $answered } of { $sent } requests were answered, in { $mean } ms on average, { $max } ms at most
first-bytes = {" "}(the first bytes: { $bytes })
controller-at = the bus controller, address { $address }
console-at = a console, address { $address }
device-at = address { $address }

# What to do about it.
do-nothing = Nothing to do.
do-check-port = Check the name of the port, that the adapter is plugged in, that you may use it (group dialout) and that no other program has it open.
do-check-network = Check host and port, that the monitor or the serial server is on, the network cable and the firewall; `lafet scan HOST` looks for open ports.
do-check-power-serial = Check the monitor's power, that A and B are not swapped, the ground wire, that the adapter switches its direction (rs485=rts if it does not do so by itself).
do-check-power-network = Check the monitor's power and its wires behind the serial server; a UDP port is silent also when no program listens there.
do-echo-known = Nothing to do: the URL says so.
do-echo-serial = It does no harm to lafet. With echo=strip in the URL it is removed; with echo=verify a difference also shows collisions. Or switch the receiver of the adapter off while it sends.
do-echo-server = The serial server echoes what it sends: switch the echo off in it (RS-485 two-wire mode).
do-no-echo = Remove echo= from the URL; without an echo it finds no collisions.
do-set-baud = Write baud={ $baud } into the URL.
do-check-speed-serial = Check baud= (19200, 57600 and 115200 are in use), 8N1, and that A and B are not swapped.
do-check-speed-network = Set the serial server's speed to that of the monitor (19200, 57600 and 115200 are in use), 8N1.
do-noise = Check termination (120 Ω at both ends only), bias resistors, ground, shield and the path of the cable near motors; try a lower speed. Check = 1 of ExternalConn makes the monitor take CRC-32C only.
do-loss = Answers come late or are lost: raise --timeout, look at the radio or the network in between, and whether another program uses this link.
do-unanswered = A device is at this address, but it answers no request: check that it is a fire monitor, restart it, and look at what is in between (radio, serial server): it may pass on short frames only, or corrupt longer ones. `lafet record` shows what arrives.
do-two-programs = Two programs that send requests disturb each other: end the other one, or put a bus controller between.
do-use-controller = There is a bus controller: no device may transmit without its token. Reach the monitor through the controller, or switch it off while you work directly.
do-two-controllers = Two bus controllers on one line: switch one of them off, or give this program an address of a console (src=129…254).
do-own-address = Give this program an address of its own (src=129…254), or end the other one.
do-set-address = Write addr={ $one } into the URL.
do-choose-address = Write the address of the monitor you mean into the URL (addr=).
do-odd-answers = Look at the monitor's program and its version: `lafet conform` shows which statements of the protocol it breaks. Nothing that it answers can be relied on.
do-start-controller = Start the controller (`lafet bus`), or remove role=active from the URL if there is none on this line.
do-no-access = Check that the controller looks for this address (--addresses) and that no other device has it (src= of the URL).
do-monitor-silent = Check the monitor's power and cable and addr= of the URL; `lafet bus who` shows which devices are on the bus.
do-change-address = Give one of them another address: switch the other off, `lafet param set general Address N`, `lafet restart`.
do-crc32c = lafet's monitors answer so with Check = 1. Clients that do not have it need Check = 0: `lafet param set externalconn Check 0`.
do-records = Write framing=records into the URL.
do-link-frames = Remove framing=records from the URL.
do-other-service = Check the port: this is some other service.

# Tuning of a drive: why it ended.
tune-valve-open = { $valve } is not closed. Close it first: a drive is tuned without water.
tune-water = Water flows although every valve is reported as closed. Shut the supply off, and check the valves.
tune-no-position = { $drive } does not report its position.
tune-limits-off = The limits of { $drive } are off, or it is not homed: a move would go on to the end of its travel. Switch its limits on first.
tune-too-little-room = The limits of { $drive } leave less than { $room }: too little to tune it.
tune-stopped = { $drive } stopped at { $at }.
tune-no-value = { $drive } does not come to rest at its target with any value. Check its gear for play and its motor for friction; the parameters are as they were.
tune-mm = { $distance } mm
tune-degrees = { $distance }°

# update/image.rs: why a file is no image that could be sent.
image-foreign = This is no image: it does not begin with LAFETIMG. `lafet image sign` makes one of a program.
image-too-large = The file has { $there } bytes, more than the { $most } MiB of an image. Is it another file?
image-cut = The file ends too early: { $there } of { $wanted } bytes are there. Copy it again, whole.
image-longer = There is something behind the end of the image: the file has { $there } bytes, the image { $wanted }. Copy it again, alone.
image-format = The image has the format { $format }, and this lafet knows format { $known }. Use the lafet that made it, or a later one.
image-unit = Byte 12: the size of the payload is { $size }; it has to be a multiple of 8, and not 0. The file is corrupt: copy it again.
image-board = Byte 24: no name of a board (1 to 16 visible ASCII characters, zeros behind them). The file is corrupt: copy it again.
image-slot = Byte 40: slot { $slot }; there are 1 (A), 2 (B) and 0 (either). The file is corrupt: copy it again.
image-key = Byte 41: key { $key }; there are 0 to 15. The file is corrupt: copy it again.
image-revokes-itself = Byte 42: the image would revoke key { $key }, with which it is signed. Sign it with another key.
image-layouts = Byte 44: the image reads layouts of parameters from { $oldest } on, and writes { $newest }. The file is corrupt: copy it again, or sign it again.
image-reserved = Bytes 10–11 or 48–63 are not zero. The file is corrupt, or made by a later lafet: copy it again, or use that lafet.
image-digest = The payload is not the one that was signed: its SHA-256 differs from bytes 64–95. The file is corrupt: copy it again.

# update/error.rs: why an update has ended.
update-not-supported = The monitor answers { $status } to Update: it cannot be updated over its link. Its program has to be built with the update, or is updated at the board.
update-deaf = The new program answers { $status } to Update: it has been built without the update, so it can be neither confirmed nor taken back over the link, and does not know that it is on trial. Do not release the monitor from its lockout. Switch its power off and on: the old program starts, locked out.
update-no-image = Slot { $slot } would be written, as the other one is running, and none of the images is for it. Give the image for slot { $slot } as well.
update-already-running = Version { $version } is running already, confirmed. Nothing was changed.
update-not-ready = The monitor is not in a state to be updated. { $why } Then update it again: it goes on where it was.
update-not-locked-out = It is not locked out: lock it out (`lafet lockout on`).
update-not-stowed = It is not in standby: stow it (`lafet wrap`), and wait until it is stowed.
update-valve-open = { $valve } is not closed: close it (`lafet close`), and wait until it is closed.
update-drive-moves = { $drive } moves: wait until it is at rest, or stop it.
update-bad-supply = Its supply is out of range (BadPower): check the supply.
update-waits-for-restart = Its parameter { $param } takes effect at the next start, and an update is a start: release it from its lockout, restart it (`lafet restart`), check that it answers where it should and with all that it should have, and lock it out again.
update-not-ready-hidden = Its status does not show why. The lockout may not be stored yet: lock it out once more (`lafet lockout on`). Or a drive has turned by itself, and its supply is cut: look at the drives.
update-refused = The monitor has not carried the order out: { $why }
update-refused-unknown = The monitor has not carried the order out, for the reason { $number }, which this lafet does not know. Use a later lafet.
update-reason-no-image = what it was sent is no image. The line or the file is corrupt: update it again.
update-reason-format = it does not know the format of the image. Sign the image with a lafet that fits the monitor's program.
update-reason-field = a field of the header is not possible. Sign the image again.
update-reason-board = the image is for another board. Take the image for this one (`lafet image show` shows the board).
update-reason-place = the image is linked for the slot that is running. Take the one for the other slot.
update-reason-size = the image is empty, does not fit into the slot, or is no multiple of 8 bytes. Build a smaller program, or sign it again.
update-reason-unknown-key = the monitor does not know the key of the image. Sign it with a key that is in the monitor's list.
update-reason-revoked-key = the key of the image has been revoked. Sign it with another key.
update-reason-revokes-itself = the image would revoke its own key. Sign it with another key.
update-reason-signature = the signature is not that of the key. Only the maker of the board can sign an image for it.
update-reason-not-newer = the image is not newer than the one that was confirmed last. Sign it with a greater version; or press the button at the board while the update starts, which allows an older one.
update-reason-layout = the image cannot read the parameters as they are stored. Take a version that can.
update-reason-nothing-started = no update has been started: it may have restarted. Update it again.
update-reason-misplaced = data came for another place than awaited. Does another program update it as well? Update it again.
update-reason-incomplete = not all data are there. Update it again: it goes on where it was.
update-reason-digest = the data that it has are not those that were signed, although the file is whole. Update it again; if this comes again, its flash is faulty.
update-reason-not-verified = the image has not been verified. Update it again.
update-reason-trial-first = an image is on trial already. Confirm it with the program that sent it, or wait 3 minutes until the monitor has gone back; then update it again.
update-reason-no-trial = no image is on trial that a word confirms. It may have gone back: update it again. If it is on trial all the same, its record is lost: only a newer version helps, or a press of the button at the board while the update starts.
update-reason-word = the word is not that of this update: another program, or another computer, has started it. Go on with that one; or wait 3 minutes until the monitor has gone back, and update it again.
update-reason-flash = its flash cannot be read or written. Update it again; if this comes again, its flash is faulty.
update-reason-not-ready = it was no longer in a state for it. See that it stays in standby and locked out, and update it again.
update-other-sender = Another program has started another update of this monitor meanwhile. Nothing more was sent: find out which of the two is wanted, and end the other.
update-stalled = The monitor answers, but the update does not go on ({ $done } of { $size } bytes). Update it again; if this comes again, restart the monitor.
update-silent = The monitor was to restart with the new image, and does not answer: { $error } What is not confirmed goes back by itself 3 minutes after its start. Then ask for its state, and update it again.
update-went-back = Version { $wanted } was tried and not kept: { $running } is running, locked out as before. The image was not heard on trial. If the line was dead or this computer asleep meanwhile, update it again. Otherwise it may crash at its start on this monitor: do not send it again before its maker has looked into it.
update-trial-ended = Version { $wanted } answered on trial, and its trial ended before it was confirmed: { $running } is running, locked out as before. If the line was dead, power was lost or this computer was asleep meanwhile, update it again. Otherwise the image crashes on this monitor: do not send it again before its maker has looked into it.
update-not-noted = What the monitor is before its restart cannot be noted here, so nothing was committed: { $error }. Correct that; the same command goes on.
update-changed = On trial the monitor was not as before, so the new image was not confirmed, and { $running } is running again. { $what } Do not send this image again before its maker has looked into it.
update-changed-still = On trial the monitor was not as before, so the new image was not confirmed; that the old one is running again was not seen. { $what } Ask for its state in 3 minutes; if it is on trial even then, switch its power off and on.
update-absent = { $subsystem } answered before, and does not answer.
update-new-fault = { $who } has the flag { $flag }, which it did not have.
update-unreadable = Its status cannot be read: { $error }

# decode_error.rs: why bytes cannot be decoded.
at-byte = at byte { $offset }: { $what }
header-expected = a record header needs 4 bytes, { $got } left
data-expected = data_size says { $size } bytes, { $got } left
other-size-expected = { $got } data bytes are not a size this record can have
other-value-expected = value { $got } is out of range
request-unknown = unknown request { $got }
frame-start-expected = a link frame starts with FF C0, got { $got }
escape-expected = after DB only DC or DD may follow, got { $got }
crc-expected = CRC should be { $crc }, frame has { $got }
crc32c-expected = CRC-32C should be { $crc }, frame has { $got }
frame-end-expected = the link frame does not end with C0
frame-too-long = the frame is longer than the { $got } bytes a receiver keeps
bytes-wrong = the bytes do not follow the protocol ({ $got })
