## What the hub says: errors, alarms, events, its configuration.

# Roles.
role-observer = observer
role-operator = operator
role-engineer = engineer
role-administrator = administrator

# Names of users.
name-length = A name has 1…64 characters, without spaces at its ends or two in a row.
name-characters = A name has letters, digits, spaces and . - _ @ + ' only.
name-letters = A name has a letter or a digit.
name-alphabets = A word of a name has letters of one alphabet: Latin and Cyrillic ones look alike.
name-of-hub = This name is the hub's own.
name-alike = This name looks like “{ $other }”, which there is already.

# Passwords.
password-short = A password has 10 characters or more.
password-guessed = This password is guessed easily. Take three or four words that have nothing to do with each other, or a longer one; no rows of keys, repetitions, dates or names.

# Alarms: the condition, its cause, what follows, what to do.
alarm-link-down = There is no connection to the monitor.
alarm-link-down-cause = The cable, the network or a serial server has failed, or the monitor has no power.
alarm-link-down-consequence = It cannot be commanded or stopped from here; what it was doing goes on by itself.
alarm-link-down-remedy = Use the button post at the monitor; check power, cable and address.
alarm-unreadable = Bytes arrive on the line of the monitor that are no frames at { $baud } baud.
alarm-unreadable-cause = Devices on the line have another speed than baud= in the configuration, or there is noise, a broken wire or no termination.
alarm-withheld-consequence = The monitor is not polled and cannot be commanded, so as not to disturb others; Stop, Close and Lockout on are sent.
alarm-unreadable-remedy = End the hub and let `lafet doctor URL` find the speed; correct baud= in the configuration, check it with `lafet serve --check` and start the hub. If it is noise that cannot be removed, insist=1 in the URL sends all the same.
alarm-controller = A bus controller transmits on the line of the monitor, and the hub is not one of its consoles.
alarm-controller-cause = The line belongs to a bus whose devices transmit in the turns that its controller grants, or a controller was connected by mistake.
alarm-controller-remedy = Write role=active and a src= of its own (129…254) into the URL of the configuration, check it with `lafet serve --check` and restart the hub; or disconnect the controller. insist=1 sends beside one that grants no access.
monitor-silent = The monitor does not answer.
alarm-stale-cause = The link is up, but the monitor is off, restarts, has another address or speed, or answers are lost.
alarm-keep-out = Water goes into keep-out “{ $name }”; the hub shuts it off.
alarm-keep-out-cause = The barrel was turned there at the monitor, or by another program.
alarm-keep-out-consequence = Water hits what the sector protects, until the valve is closed.
alarm-keep-out-remedy = Warn the people there. Turn the barrel away with the valves closed. Close the hand valve if water still flows.
alarm-unheld = A motion by hand may go on for more than 0.5 s if the hub or the connection fails.
alarm-unheld-cause = The monitor has no parameter MoveHold: its drive stops after about 2 s. Or the line is slow (round trip of 180 ms and more): the drive stops after three round trips or so.
alarm-unheld-consequence = People near the barrel while it is moved by hand are in danger for longer.
alarm-unheld-remedy = While it is moved by hand, keep the hardware emergency stop within reach. Install firmware with MoveHold, or make the line faster; shelve the alarm where neither is possible.
alarm-recordings = The folder of the recordings cannot be used.
alarm-recordings-cause = It cannot be made, read or written: a path that is wrong or not mounted, rights, a full or read-only disk; the hub's log says which.
alarm-recordings-consequence = Nothing is recorded around alarms and on demand; everything else goes on.
alarm-recordings-remedy = Correct folder in [recording], or its rights, mount or free its disk; it is tried again each minute and for each recording.
alarm-disk = The disk of the hub's state is almost full.
alarm-disk-low-cause = Less than 500 MB are free, or less than 5 % of the disk and 5 GB; Users → Hub shows what takes space.
alarm-disk-consequence = When it is full, the audit log, events and history wait in memory and are lost if the hub ends.
alarm-disk-remedy = Make room: remove recordings or what other programs have left, or shorten the times of storage in hub.toml.
alarm-certificate = The certificate of the hub ends within 30 days, or has ended.
alarm-certificate-cause = It was not replaced in time.
alarm-certificate-consequence = Browsers and programs refuse to connect to the hub once it has ended.
alarm-certificate-remedy = Put a new certificate with its key in place of the files in hub.toml; the hub reads them by itself.
certificates-read = The certificates were read again: they have changed.
certificates-useless = The certificates have changed and cannot be used, the old ones stay: { $what }
alarm-audit = The audit log is not being stored.
alarm-disk-cause = The disk is full, read-only or has failed.
alarm-audit-consequence = Commands go on; their entries wait in memory and are lost if the hub ends.
alarm-audit-remedy = Make room on the disk or repair it; the entries are then stored by themselves.
alarm-chain = The audit log was changed.
alarm-chain-cause = audit.db was edited, or the disk has corrupted it.
alarm-chain-consequence = Control is not affected. Entries from the one that is named in the event log on prove nothing.
alarm-chain-remedy = Keep a copy of the folder for the investigation; then restore audit.db, or put it aside and start with --accept-lost audit.
alarm-state = Files of the state were lost.
alarm-state-cause = Files in the hub's folder were removed, replaced or cut, or the disk does not let them be read; the event log names them.
alarm-state-consequence = Control is not affected. What was in them is missing.
alarm-state-remedy = Find out who or what did it, restore a copy if there is one; then acknowledge.
alarm-logins = Passwords are being guessed.
alarm-logins-cause = Many logins have failed in the last minutes; the audit log has their users and addresses.
alarm-logins-consequence = A login from a new place has to wait. Places from which a user has logged in before do not.
alarm-logins-remedy = Find the addresses in the audit log and cut them off from the network of the hub.
alarm-revocations = Ended sessions and removed users are not stored.
alarm-revocations-consequence = They are in effect. If the hub restarts before the disk takes them, they may be undone.
alarm-revocations-remedy = Make room on the disk or repair it before the hub is restarted.
alarm-zones = Modes, masks and refusals of the zones are not stored.
alarm-zones-consequence = They are in effect. If the hub restarts before the disk takes them, zones that are off or locked are as they were stored last.
alarm-zones-remedy = Make room on the disk or repair it before the hub is restarted; then repeat what the zones have lost.
alarm-history = The history is not being stored.
alarm-history-cause = The disk is full or faulty; or PostgreSQL, if it is used, does not answer or refuses the hub.
alarm-history-consequence = Control is not affected. Values of this time are missing; PostgreSQL's wait in memory until there are too many.
alarm-history-remedy = Make room on the disk, or correct the server or url in [history].
alarm-events = The event log is not being stored.
alarm-events-cause = The disk is full, faulty or does not answer, or events.db is damaged; the hub's log says which.
alarm-events-consequence = Control is not affected. 10,000 events wait in memory; after a restart those are missing, and alarms may be as they were stored last.
alarm-events-remedy = Make room on the disk, or replace it. If events.db is damaged, stop the hub, move the file to another folder and start the hub again.

# Alarms of the zones.
alarm-trouble = { $subject }: { $trouble }.
alarm-detector-cause = The detector or its gateway has no power, no link or a fault, or its window is dirty.
alarm-detector-consequence = It has no vote: its zones may release later, or only alarm.
alarm-detector-remedy = Watch its area; look at the detector, its gateway and its link.
alarm-idle-cause = It refuses, a valve or drive does not move, or its post is locked.
alarm-idle-consequence = Another monitor is used in its place, if the zone has one.
alarm-idle-remedy = Take control and open it by hand, or use its button post.
alarm-not-closed-cause = The valve does not close, its sensor has failed, or the monitor does not answer.
alarm-not-closed-consequence = Water may still run.
alarm-not-closed-remedy = Look whether water runs; shut it off at the monitor.
alarm-no-monitor-cause = All of its monitors are lost, failed, locked, closed or controlled by people.
alarm-no-monitor-consequence = A released zone gets no water.
alarm-no-monitor-remedy = Extinguish by other means; give control of a monitor up, or reset it.
alarm-few-jets-cause = Monitors of the zone are lost, failed, locked, closed or controlled by people, and there is no other in their place.
alarm-few-jets-consequence = The zone gets less water than it was planned with.
alarm-few-jets-remedy = Give control of a monitor up or reset it; support the zone by other means.
alarm-path-cause = A broken wire, a device without power, or a bus that does not answer.
alarm-path-consequence = An input counts as it was last: a press of it is not seen. An output may not do what it is ordered.
alarm-path-remedy = Use the console or the posts of the monitors, valves and pumps by hand; look at the wire and the device.
alarm-output-cause = The line or the device does not take the order, or the valve, relay or contactor does not move.
alarm-output-consequence = It may still be as it was before. The order is repeated every second.
alarm-output-remedy = Operate it by hand on the spot; look at the device and its limit switch.
alarm-pump-cause = The pump does not run, has no water, or its pressure switch or line has failed.
alarm-pump-consequence = A pump on standby starts in its place, if there is one. Jets may be short.
alarm-pump-remedy = Start a pump by hand on the spot; look at its supply, suction and pressure switch.
alarm-contact-cause = The button is still pressed, or its contact is welded.
alarm-contact-consequence = A release station releases nothing, and a hold holds nothing, until it was seen released.
alarm-contact-remedy = Reset the button; if the trouble stays, look at its contact.
alarm-zone-disabled = Zone { $subject } is disabled: not in automatic, ended or locked.
alarm-zone-disabled-cause = A person's order.
alarm-zone-disabled-consequence = A fire is only an alarm; water comes by hand, if at all.
alarm-zone-disabled-remedy = Watch the zone. Afterwards set automatic, reset it or unlock the zones.
alarm-zone-not-ready = Zone { $subject } is not ready: it would release nothing by itself.
alarm-zone-not-ready-cause = Too many of its detectors have failed, or none of its monitors can serve it.

# The page that replaces the console where it was not built.
console-not-built = The hub runs, but the console was not built in
console-not-built-remedy = Build the console with these commands, then the program again. The API works without it.

# What the API refuses.
answers-too-many = Too many answers are still being taken. Try again.
csrf-missing = The header X-CSRF-Token is missing or wrong: take it from /api/session.
body-unreadable = The body cannot be read; at most { $body_max } bytes.
not-understood = Not understood: { $error }. See /api/openapi.json.
login-first = Log in first.
host-unknown = The hub has no such name. Add it to names in [server], or use its address.
origin-unknown = Another page asks. If it may, add it to origins in [server].
jets-too-many = At most { $jets_max } jets in a request.
toward-wrong = toward is max or min.
no-parquet = This lafet is built without Parquet. Take /api/history.csv, or build with the feature parquet.
encoding-refused = The hub takes bodies of requests as they are, without Content-Encoding.
past-too-long = At most 24 hours at a time.
seconds-range = seconds is { $from }…{ $to }.
recording-not-frames = This is no recording of frames: { $error }.
upload-broken = The file has not arrived: { $error }.
upload-too-large = The file is too large; at most { $megabytes } MiB.
shelve-range = It takes a reason of 1…{ $reason_max } characters and 1…{ $shelve_max_min } minutes.
reason-control = A reason has no line breaks and no other control characters.
times-wrong = from_ms must not be after to_ms, nor either after { $time_max_ms }.
no-password = Only a user who has logged in with a password has one.
sim-at-or-name = Give at or name.
sim-out-of-range = { $name } = { $value } is out of range: { $from }…{ $to }.
subscribed-too-many = At most { $subscribed_max } monitors; without a list, all of them.
detector-kind-differs = kind is not that of the configuration. Correct hub.toml, or the detector that reports here.
detector-place-range = bearing_deg is 0…360, elevation_deg −90…90, quality 0…1.
wind-range = from_deg is 0…360, speed_mps 0…40.
check-supply = `[supply]` needs `pressure`; or `static`, `flow` and `pressure`; or `curve`.
check-flowing = `flowing` of `[supply]` is not 1 to { $most }.
check-winds-too-many = There are more than { $most } winds.
check-planned-remedy = (docs/coverage.md has the bounds of all keys.)
check-obstacles = The planner of the zones takes at most { $most } tanks and walls together: with more it assigns no monitor.

# The clock.
clock-stepped = The clock was changed by { $by_s } s, or the machine was asleep.

# Requests.
only-set-param = `save` is for SetParam only.
request-too-long = The request is too long.
bus-controller-own = This is the bus controller's own.

# What is wrong with hub.toml, and what to write.
check-open-without-login = login = false, but { $listen } can be reached from other machines.
check-open-without-login-remedy = Set login = true, or listen on 127.0.0.1.
check-plain-passwords = Passwords would travel in the clear to { $listen }.
check-plain-passwords-remedy = Add [tls] with cert and key; or, behind a proxy that has TLS, plain_http = true.
check-file-readable = Every user of this machine can read { $name }.
check-listen = `{ $text }` is no place to listen.
check-listen-remedy = Write ADDRESS:PORT, as 127.0.0.1:8480 or 0.0.0.0:8480.
check-pem-files-remedy = sslrootcert, sslcert and sslkey name PEM files; relative ones start from the folder of this file.
check-out-of-range = { $name } = { $value } is out of range.
check-out-of-range-remedy = Write { $from }…{ $to }.
check-client-roles = client_roles without client_ca.
check-client-roles-remedy = Add client_ca: the file with the certificate that signs clients.
check-pem-remedy = Give the path of a PEM file; relative ones start from the folder of this file.
check-input-no-zone = There is no zone for it.
check-input-no-zone-remedy = Add [[zone]], or remove the input.
check-output-no-zone-remedy = Add [[zone]], or remove the output.
check-target = `{ $text }` says nothing that can be written.
check-target-table = `{ $text }`: discrete and input are only read.
check-target-no-value = `{ $text }`: which bit or values of the register are meant?
check-target-same = `{ $text }`: on and off are the same.
check-target-remedy = Write coil:12, holding:100.3, holding:100=1/0 or holding:100&0x00FF=0x0012/0: the values for on and off; ! in front inverts.
check-same-target = { $id } and { $other } both write { $bit }: one would undo the other.
check-same-target-remedy = Give each output a bit of its own.
check-target-alarms = { $id } writes { $bit }, which is read as { $other }: the hub would cause its own signal.
check-target-alarms-remedy = Correct unit and bit of one of them.
check-own-feedback = { $id } writes { $bit } and reads it as its report: it says what was written, not what has happened.
check-own-feedback-remedy = Name the bit of a limit switch or relay, or remove it: what was written is read back anyway.
check-part-unread = { $id } writes a part of a register, whose rest cannot be left as it is without reading it.
check-part-unread-remedy = Remove read_back = false, or give the output the whole register: holding:100=1/0.
check-unconfirmed = Nothing shows whether { $id } is open or runs as ordered.
check-unconfirmed-remedy = Remove read_back = false, or name the bit that reports it: on.
check-single-reading = { $id } would release by a single reading.
check-single-reading-remedy = Write debounce_ms = { $least } or more (1000 at most), or a smaller poll_ms of { $name }.
check-bus-name = `{ $name }` is no name of a bus.
check-bus-name-remedy = Write 1…32 letters a–z, digits, - or _.
check-bus-twice = { $name } is given twice.
check-bus-twice-remedy = Give each bus a name of its own.
check-bus-same-line = The bus { $name } is on the same line.
check-bus-same-line-remedy = A line is one [[modbus]], with all of its devices.
check-bus-with-monitor = A monitor is on this line, with a protocol of its own.
check-bus-with-monitor-remedy = Give the detectors a line of their own.
check-bus-unknown = There is no bus { $name }.
check-bus-unknown-remedy = Add [[modbus]] with name = "{ $name }", or correct the name.
check-key-meaningless = { $key } has no meaning here.
check-key-meaningless-remedy = With map = "fv300": register, axis, field; with map = "notifier": register; without map: alarm and other bits, and heartbeat_s with heartbeat.
check-axis-and-field = axis and field belong together.
check-view = No detector is mounted so.
check-register-missing = register is missing.
check-register-missing-remedy = Write the register of the point, counted from 0.
check-alarm-bit-missing = The bit that alarms is missing.
check-alarm-bit-missing-remedy = Write alarm = "discrete:12", or map = "fv300".
check-heartbeat = heartbeat without heartbeat_s.
check-heartbeat-remedy = Write heartbeat_s: twice the time in which the bit changes, s.
check-same-bit = { $id } and { $other } have the same alarm bit ({ $bit }): one device would vote twice.
check-same-bit-remedy = Correct unit and bit, or remove one of them.
check-one-unit = All votes that zone { $zone } needs can come from device { $unit } on { $bus }, whose faults nothing would show: if it writes wrong bits, water flows.
check-one-unit-remedy = Give its detectors a heartbeat or a fault bit, or put some of them on another device.
check-same-reading = { $id } and { $other } read the same bit ({ $bit }) of device { $unit } on { $bus }: one of them is not what it says.
check-same-reading-remedy = Correct unit and bit, or remove one of them.
check-silent-too-soon = { $id } is silent after { $silent } ms, but { $name } needs { $own } ms to try twice.
check-silent-too-soon-remedy = Write a smaller poll_ms or timeout_ms of { $name }, or silent_after_s = { $least } or more.
check-bus-unused = Nothing is on the bus { $name }: it would have no effect.
check-bus-unused-remedy = Write source = { "{" } modbus = "{ $name }", unit = 1, … { "}" } in a [[detector]] or [[input]], target = … in an [[output]] or [[pump]], or remove the bus.
check-round-too-long = One round on { $name } takes { $round } ms at this speed, more than poll_ms = { $poll_ms }.
check-round-too-long-remedy = Write poll_ms = { $poll_ms } or more, a higher speed, or divide the bus.
check-view-remedy = Write axis = [bearing 0…360, elevation −90…90] and field = [width, height], 1…180, all in degrees.
check-example-remedy = For what is allowed here: lafet serve --example.
check-no-monitor = There is no monitor.
check-no-monitor-remedy = Add one: [[monitor]] with id = "M1" and url = "tcp://192.168.1.50?addr=1".
check-monitor-id = `{ $id }` is not an id.
check-monitor-id-remedy = Write 1…32 letters a–z, digits, - or _; what people read is name.
check-monitor-twice = { $id } is given twice.
check-monitor-twice-remedy = Give each monitor an id of its own.
check-no-simulator = The hub has no simulator inside.
check-no-simulator-remedy = Run `lafet sim` and write the address that it prints.
check-same-url = { $url }: two monitors with the same URL.
check-same-url-remedy = Give each its own address: ?addr=2.
check-url-remedy = Write tcp://HOST:PORT?addr=1, udp://… or serial:///dev/ttyUSB0?baud=19200.
check-host-name = `{ $name }` is no name.
check-host-name-remedy = Write the name alone: hub.site.example, without http:// and port.
check-origin = `{ $text }` is no origin.
check-origin-remedy = Write https://NAME or https://NAME:PORT, without a path; * is not allowed.
check-keep-out-name = The name of keep-out “{ $name }” cannot be used.
check-keep-out-name-remedy = Give each keep-out a name of its own with 1…{ $most } characters.
check-keep-out-angles = Keep-out “{ $name }” is no sector.
check-keep-out-angles-remedy = Bearings are −360…360°, from and to, clockwise; elevations −90…90°, the lower one first.
check-keep-out-narrow = Keep-out “{ $name }” has no width or no height: it would protect a line.
check-keep-out-narrow-remedy = Give two different bearings, clockwise from the first to the second, and two different elevations; bearings = [0, 360] is the whole circle.
check-keep-out-monitor = Keep-out “{ $name }” is for monitor { $monitor }, which is not configured.
check-keep-out-monitor-remedy = Write the id of a [[monitor]], or leave monitor out: the sector then counts for all.
check-keep-out-place = Keep-out “{ $name }” counts for { $monitor }, which has no place.
check-keep-out-place-remedy = Bearings count from north: give { $monitor } its at, heading and height.
check-keep-out-aim = { $monitor } aims at zone { $zone } where keep-out “{ $name }” is.
check-keep-out-aim-remedy = Aim elsewhere, or correct the sector: water is not sent into it.
check-keep-outs-too-many = There are more than { $most } keep-outs.
check-keep-outs-too-many-remedy = Join sectors that touch.
check-plan = This cannot be on the plan.
check-plan-remedy = Places are metres within 100 km, headings −360…360°, heights 0…1000 m, diameters more than 0.
toml-unknown = { $name } is not known here; what is: { $known }.
toml-not-one-of = { $name } is not one of { $known }.
toml-missing = { $name } is missing.
toml-twice = This is given twice.
toml-no-vote = { $votes } is no vote: write 2oo3 for two of three detectors.
toml-meant = Did you mean { $name }?
check-no-driver = [[{ $table }]]: the hub has no driver for it: it would have no effect.
check-no-driver-remedy = Remove it, or give an input its `source`, an output or a pump its `target` on a [[modbus]]. Abort, hold and release are given over HTTP too.
check-aims = zone { $id }: { $count } aims of monitor { $monitor } instead of one.
check-aims-remedy = Write one [[aim]] with zone = "{ $id }", monitor = "{ $monitor }", horizontal, vertical and nozzle.
check-poll-seldom = { $name } serves zone { $id }: this is too seldom to confirm a Close.
check-poll-seldom-remedy = Write { $poll_ms_max } or less.
check-not-served = Monitor { $name } does not serve a zone { $of }.
check-not-served-remedy = Correct zone and monitor, or name the monitor in `monitors` of the zone.
check-aim = No monitor can aim so.
check-aim-remedy = program is 0…7, horizontal and vertical are −21600…21600 arc-minutes, nozzle is mm from 0.
check-station = A detector cannot be there, or its bearings have no such error.
check-station-remedy = at = [east, north, up] in metres within 10 km, error_deg from { $least } to { $most }.
check-no-place = error_deg is of a detector that has no place.
check-no-place-remedy = Write at = [east, north, up] too, in metres, or remove it.
check-stations-too-many = zone { $zone }: more than { $most } detectors with a place.
check-stations-too-many-remedy = Remove `at` of those that add least: three stations around a zone are enough to tell two fires from ghosts.
toml-kind = { $given } where { $wanted } is needed.
toml-kind-value = { $kind }{ $value }
check-zones = { $place }: { $what }

# Motion by hand.
jog-axes = Only Vertical, Horizontal and Nozzle are moved by hand.
jog-taken-over = { $by } has taken the drive over.
jog-still-moving = The drive goes on in spite of Stop. Use the emergency stop.
jog-unbounded = Limits are off, and this monitor would not end the motion by itself if the connection failed. Switch the limits on, or set MoveTimeout of General, 500 ms for example.

# Errors of the API.
no-monitor = There is no monitor { $id }.
nothing-stopped = There is no monitor { $id }: nothing was stopped or closed. It may have another name now: reload the page. POST /api/stop stops every monitor.
no-zones = No zones are configured. See docs/installation.md.
no-detector = There is no detector { $id }. Add it to the configuration, or correct the name.
detector-on-bus = Detector { $id } is read on the bus { $bus }. Remove `source` from hub.toml to report it here.
order-void = The order was withdrawn before it was sent.
sent-in-future = `up_ms` is ahead of the hub's: add the time since a message of this hub to its `up_ms`.
request-late = The request was on its way for too long, and was not carried out. Send it again if it is still wanted; reload the page if that happens each time.
beat-late = The signals of the held control arrive late: the network or the computer was busy. Release the control and hold it again.
confirm-needed = This needs "confirm": "{ $id }", so that it is not done by mistake.
nothing-here = There is nothing here. See /api/openapi.json.
role-needed = This needs the role { $role }.
session-ended = This session was ended: only Stop still works, for ten minutes. Log in.
too-fast = Too fast. Try again in { $wait_s } s.
control-held = { $monitor } is held by { $user }. Request control, or wait.
control-free = No client holds { $monitor }. Take control first.
control-not-asked = No client asks for control.
force-needs-reason = Taking over by force needs a reason, 5 characters or more.
keep-out-met = Keep-out “{ $name }”: water must not go there. Turn the barrel away with the valves closed, or choose another direction.
keep-out-unknown = Keep-out “{ $name }”: it is not known where the barrel points, so water could go there. Stop the barrel, and look at its position, limits and link.
not-connected = There is no connection to { $monitor }. Nothing was sent.
no-answer-within = { $monitor } has not answered for { $seconds } s. Check its link, and ask again.
postgres-away = PostgreSQL, which has the history, does not answer. Check that server.
postgres-failed = PostgreSQL, which has the history: { $error }. Check that server.
storage-failed = The hub's storage does not work: { $error }. Check the disk.
store-engine = { $error }
store-away = PostgreSQL does not answer
store-busy = too much waits for the disk
store-unread = the disk did not let the file be read when the hub started
store-in-use = another hub uses { $folder }
store-newer = { $folder } was written by lafet { $program } (format { $format } of the state); this is lafet { $own }, which knows formats up to { $known }. Nothing was changed. Install lafet { $program } or a later version again, or restore a copy of the folder from before the update.
store-newer-unknown = { $folder } was written by a later version of lafet (format { $format } of the state); this is lafet { $own }, which knows formats up to { $known }. Nothing was changed. Install that version again, or restore a copy of the folder from before the update.
store-zones = the stored state of the zones cannot be read: { $error }
store-shared = { $folder } can be written by other users of this machine and holds what is not the hub's
store-no-room = nothing can be written in { $folder } ({ $error }). A hub needs at least 1 MB there for its first start, and 40 MB with its reserve. Nothing was started: make room or choose another folder (data), and start it again.
store-file = { $file }: { $error }
login-failed = Wrong user, password or link. Each failure makes the next try wait longer.
access-conflict = There is one of this name already, or it is the last administrator.

# Buses of detectors: events.
bus-open = Modbus { $name }: the line is open.
bus-lost = Modbus { $name }: no connection. { $why }
bus-reading = { $sort } { $id } (modbus { $bus } unit { $unit }): { $news }.
bus-detector = Detector
bus-input = Input
bus-output = Output
bus-pump = Pump
bus-output-fault = its fault contact is set
bus-output-dropped = the device has lost what it was ordered, as after a restart; ordered again if it is still wanted
bus-output-refused = the device refuses the write
bus-reading-lost = no valid answer; a fault
bus-reading-frozen = its heartbeat does not change; a fault
bus-reading-back = it is read again

# Buses of detectors: their lines.
check-line = `{ $url }` is no line.
check-line-remedy = Write tcp://10.0.0.9:502, rtu+tcp://10.0.0.9:4001 or serial:///dev/ttyUSB1?baud=19200&parity=even.
check-line-option = `{ $url }`: { $name } cannot be given so.
bus-takes-nothing = It takes no more bytes.

# Buses of detectors: addresses of bits.
check-point-one-bit = `{ $text }`: a coil or discrete input is one bit, and has no bits or mask.
check-point-no-bit = `{ $text }`: which bit of the register is meant?
check-point-remedy = Write discrete:12, coil:12, holding:100.3 or input:100&0x00F0=0x0020; the address counts from 0, the bit is 0…15, and ! in front inverts.
check-point = `{ $text }` names no bit.
check-point-address = `{ $whole }`: the address is not 0…65535.
check-point-bit = `{ $whole }`: the bit is not 0…15.
check-point-mask = `{ $whole }`: the value has bits that the mask has not, or the mask has none.

# Buses of detectors: answers.
bus-no-answer = No answer in time.
bus-other-unit = Unit { $unit } has answered instead.
bus-other-function = The answer is to function { $function }, which was not asked for.
bus-other-count = The answer has another number of values than was asked for.
bus-other-value = The answer confirms another value than was written.
bus-given-up = Not waited for: an order came.
bus-no-frame = What came is no Modbus frame. Check speed, parity and the other end of the line.
bus-exception = Exception { $code }: { $why }.
bus-function = function not supported
bus-address = no such address
bus-value = value refused
bus-device = device failure
bus-busy = device busy
bus-no-path = gateway: no path
bus-behind-gateway = gateway: the device does not answer
bus-unknown-code = not in the standard

# Control.
reason-too-long = reason has at most { $reason_max } characters.
action-unknown = `{ $action }` is none of { $list }.
control-expired = { $monitor }: control of { $user } is lost, drives are stopped.

# State of a monitor.
link-connected = Connected again.
link-lost = No connection: { $error }.
check-link-remedy = Check the power, the cable and the address in the configuration.
link-down = There is no connection.
barrel-stowed = The barrel is stowed.
barrel-stowed-remedy = Deploy it; a search or extinguishing deploys it by itself.
no-move-hold = The monitor has no parameter MoveHold: if the hub or the connection fails during a motion by hand, the drive stops after about 2 s, not within 0.5 s.
no-move-hold-remedy = While it is moved by hand, keep the hardware emergency stop within reach; firmware with MoveHold ends the motion sooner.

# Jets.
jet-value-needed = { $name } is needed where no monitor is given.
jet-target-range = way_m is 0 … { $way_max_m } m, rise_m −{ $way_max_m } … { $way_max_m } m.

# State of the hub.
audit-changed = The audit log was changed: entry { $n } is not the one that was written.
state-missing = { $name } is missing or empty, the other files of the state are not.
state-foreign = { $name } does not belong to this site: it is from another folder or copy.
state-cut = { $name } was cut or is an older copy: { $found } instead of at least { $noted } entries.
state-changed = { $name } was changed: entry { $n } is not the one that was noted.
state-altered = users or tokens in { $name } are not as the hub left them, and the audit log has no entry for it: another program changed them, or the hub was killed at that moment. Compare them with the audit log.
state-no-users = { $name } has no user, although there were users.
state-unread = The disk does not let { $name } be read: { $error }. The hub works without what is in it and does not change it. Repair the disk or the connection to it, then restart the hub.
state-malformed = { $name } cannot be read: { $error }.
state-set-aside = { $name } could not be read: { $error }. It is kept as { $aside }; a new one takes its place.

# PostgreSQL.
no-postgres = This lafet is built without PostgreSQL.
no-postgres-remedy = Leave url out for SQLite, or build with the feature postgres.
postgres-sslmode = sslmode={ $other } is unknown.
postgres-sslmode-remedy = Write disable, allow, prefer, require, verify-ca or verify-full.
postgres-address = This is no address of PostgreSQL.
postgres-address-remedy = Write postgres://USER:PASSWORD@HOST/DATABASE, or leave url out for SQLite.
postgres-verify-by-what = The server is to be verified, but nothing is given to verify it by.
postgres-verify-by-what-remedy = Add sslrootcert=FILE (the certificate that signs it), or sslrootcert=system.
postgres-system-not-full = sslrootcert=system without verify-full: anyone can get such a certificate.
postgres-verify-full-remedy = Write sslmode=verify-full.
postgres-verifies-nothing = sslrootcert is given, but sslmode verifies nothing.
postgres-cert-and-key = sslcert and sslkey go together.
postgres-cert-and-key-remedy = Write both, or neither.
postgres-no-authority = This machine trusts no authority (Debian: apt install ca-certificates).

# Events of the zones.
zones-not-stored = Modes, masks and refusals of the zones are not stored: a restart would lose them. Check the disk.
water-timeout-off = WaterTimeout is 0: if the hub fails, the monitor does not end water of zone { $zone } by itself. Set it to { $most } s.
water-timeout-longer = WaterTimeout is { $seconds } s, more than water_max_s of zone { $zone } ({ $most } s): if the hub fails, water runs for longer than the zone may give it. Set it to { $most } s.
zones-stored = Modes, masks and refusals of the zones are stored again.
zones-no-wind = The anemometer has reported nothing for { $minutes } min: monitors are assigned by the last wind.
zones-wind-known = Monitors are assigned by the wind that was reported last: { $speed } m/s from { $from }°.
zones-wind-unknown = No wind was reported: monitors are assigned as in still air. The only reserve for a wind is that a fire counts as within reach up to { $percent } % of the throw.
zone-detector-alarm = Detector { $detector }: alarm ({ $by }).
zone-countdown = Zone { $zone }: enough votes, release in { $seconds } s.
zone-held = Zone { $zone }: the delay is held.
zone-hold-over = Zone { $zone }: the hold is over.
zone-water-found = { $monitor }: water was running when the hub started; it is closed after { $seconds } s.
zone-water-gone = { $monitor }: no zone of the file has it any more, and its water may be running; it is closed after { $seconds } s.
zone-water-lost = { $monitor } is not in the file any more, and its water may be running: close it by hand.
zone-monitor-replaced = Zone { $zone }: { $monitor } is used in place of another monitor.
why-lockout = lockout
why-abort = abort
why-duration = greatest duration
why-quiet = no detector in alarm
why-test-over = the test is over
why-votes = too few votes
why-mode = not in automatic
mode-automatic = automatic
mode-manual = manual
mode-off = off
mode-test-dry = dry test
mode-test-outlet = test of the outlet
zone-news = Zone { $zone }: { $news }.
zone-stored-mode = Zone { $zone } starts as it was stored: { $stored }. The file says: { $file }.
zone-stored-gone = { $what } is not in the file any more; what was stored of it (a mode, a mask, a refusal, or that a pump is kept off) does not count.
zone-station-refused = Release point { $input }: zone { $zone } is not released. { $why }
zone-cancelled = Zone { $zone }: cancelled ({ $why }).
zone-ended = Zone { $zone }: the release ended ({ $why }).
zone-no = { $scope }: { $why }; it lasts until a reset.
zone-reset = { $scope }: reset.
zones-lockout-on = Zones: lockout is on.
zones-lockout-off = Zones: lockout is off.
zone-not-planned = Zone { $zone }: monitors cannot be assigned to fires ({ $why }). The nearest ones go first; see the plan of the site in hub.toml.
zone-planned = Zone { $zone }: monitors are assigned to fires again.
zone-trouble = { $subject }: { $trouble }.
zone-trouble-over = { $subject }: { $trouble }, over.
released-dry = released in a test, without water
released-by-votes = released by votes
released-by-hand = released by hand
scope-site = All zones
scope-zone = Zone { $zone }

# Files of certificates and keys.
file-wrong = { $path }: { $what }.
file-no-certificate = no certificate in it
file-no-key = no private key in it
file-unreadable = cannot be read: { $error }
file-no-pem = no PEM: { $error }
file-useless = { $error }

# Kinds of values in hub.toml: what is needed, what is given.
kind-a-string = a text in quotes
kind-a-boolean = true or false
kind-a-list = a list: [[…]] or […]
kind-a-table = a table
kind-whole = a whole number
kind-whole-from-0 = a whole number from 0
kind-a-number = a number
kind-a-path = a path in quotes
kind-two-numbers = two numbers: [east, north]
kind-integer = the number
kind-fraction = the fraction
kind-string = the text
kind-boolean = the value

# Figures of a link.
figure-sent = Frames sent in a second
figure-received = Frames received in a second
figure-retries = Frames sent again in a second
figure-timeouts = Answers that did not come in a second
figure-errors = Frames with errors on the line in a second
figure-rtt = Smoothed round trip
figure-ms = ms

# Alarms of flags: what follows.
flag-drive = The axis cannot be trusted: it stops and may refuse to move, so the jet cannot be aimed.
flag-deployer = The barrel may stay stowed: then it can neither aim nor give water.
flag-heating = In frost the unit may freeze and no longer move.
flag-remote = Parameters on the remote unit may not be what they are shown to be.
flag-button = This button of the post does nothing; the others go on working.
flag-config-fault = The subsystem works with default values: limits and zero point may be wrong.
flag-config-invalid = The subsystem may refuse to work until its parameters are complete.
flag-config-write-fault = What was set is lost when the power goes.
flag-conn-lost = The monitor cannot command this unit: it stays as it is.
flag-bad-power = Drives and valves may be slow, stop, or not work at all.
flag-internal-fault = What the subsystem was doing has ended; extinguishing may have stopped.
flag-wdt-fault = The unit was reset: what it was doing has ended.
flag-protocol-fault = Some commands do not reach the unit.
flag-pressure-sensor = The pressure is not known; programs aim without ballistics, the jet may fall short.
flag-locked-out = All motion is stopped and the valves are closed; every command is refused.
flag-heating-sensor = Heating of this part is not controlled: in frost it may freeze.
flag-valve-overload = The valve has stopped midway: it may be partly open.
flag-drive-overload = The drive has stopped and refuses this direction until the flag goes.
flag-limitless = Nothing keeps the barrel from running against its stops.
flag-blocked = The valve does not open on command.
flag-valve-sensors = It is not known whether the valve is open or closed.
flag-outside-limits = Part of the fire is not reached by the jet.
flag-mode-fault = The program does not run.
flag-trajectory = The barrel aims straight at the target: far away the jet falls short.
flag-found = Something burns in the searched sector.
flag-device-fault = The monitor does not find fires: an operator has to look and aim by hand.
flag-bad-sector = The search does not run.
flag-dirty-lens = Small or distant fires may be overlooked.

# Tuning of a drive.
tune-drives = Only Horizontal, Vertical and Nozzle can be tuned.
tune-put-back = { $drive }: a tuning was cut off; StopLag and MinSpeed are as before it.
tune-not-put-back = { $drive }: a tuning was cut off, and StopLag and MinSpeed could not be put back: { $error }
tune-not-written-back = { $drive }: StopLag and MinSpeed from before the tuning could not be written back: { $error }
tune-not-stored = the monitor could not write its memory (ConfigWriteFault), and they are in force until its next reset. Check its supply.
tune-note-bad = What a tuning has changed is not known: { $file }: { $error }. Check StopLag and MinSpeed of the drives, then delete the file.
tune-not-noted = Ended: the values before cannot be noted on the disk: { $error }.
tune-running = A drive of this monitor is being tuned already.
tune-interrupted = Ended by STOP or another command to the monitor.
tune-ended = Ended by its operator.
tune-authority-lost = Ended: control of the monitor was lost.
tune-page-gone = Ended: the page that started it does not answer.

# Updates of monitors' software: what is refused.
updates-run-already = An update runs already, started by { $user }. Wait until it has ended, or stop it.
updates-none-runs = No update runs.
updates-images-number = Give one image, or two: one for slot A and one for slot B.
updates-image-missing = The hub has no image { $digest }. Upload it first.
updates-not-a-set = Two images have to be of one version for one board, one linked for slot A and one for slot B.
updates-pace-range = pace is 1…100.
updates-no-monitors = There is no monitor to update.
updates-images-full = The hub has { $most } images already. Remove one that is no longer needed.
updates-image-in-use = This image is being sent. Wait until the update has ended, or stop it.
updates-image-differs = The hub has an image of the same payload with another header: version { $version } for { $board }. Remove that one first.
updates-image-unusable = The image { $digest } cannot be used: { $error } Remove it, and upload it again.
updates-order-refused = The software of { $monitor } is being updated: until that has ended, only Stop, Close and Lockout are sent. If the monitor is needed, stop the update first.

# Why a monitor is not updated.
updates-not-stowed = It is not in standby: stow it, and wait until it is stowed.
updates-valve-open = { $valve } is not closed: close it, and wait until it is closed.
updates-drive-moves = { $drive } moves: wait until it is at rest, or stop it.
updates-bad-supply = Its supply is out of range (BadPower): check the supply.
updates-general-silent = General does not answer with its state: check the monitor.
updates-program-runs = It carries out a program: wait until that has ended, or stop it.
updates-tuning-runs = One of its drives is being tuned: wait until that has ended.
updates-fire-found = Its detector has found a fire.
updates-zone-not-quiet = Zone { $zone } is not quiet: wait until its alarm and its release are over, and reset it.
updates-other-silent = { $other } does not answer, and serves zone { $zone } as well: two monitors of a zone must not be out of service at once. Wait until it answers.
updates-other-locked = { $other } is locked out, and serves zone { $zone } as well: two monitors of a zone must not be out of service at once. Release its lockout first.
updates-not-locked = It was not locked out: { $error }
updates-lockout-not-stored = It is locked out, but has not stored that: after a loss of power it would be released. Check whether General has the flag ConfigWriteFault.
updates-word-not-noted = What confirms the update cannot be noted on the disk of the hub: { $error }. Nothing was sent: check the disk.
updates-no-random = The system has no random bytes for the update: { $error }. Nothing was sent.
updates-other-image = It has another image committed or on trial, which this hub has sent. Update it with that image to confirm it, or wait until it has gone back by itself, 180 s after its start.
updates-sent-elsewhere = It has an image committed or on trial that this hub has not sent, so nothing here confirms it. Update it from where that was sent, or wait until it has gone back by itself, 180 s after its start.
updates-note-unreadable = It has an image committed or on trial, and what confirms it cannot be read from { $file }. Wait until it has gone back by itself, 180 s after its start, or restart it. Then update it again.
updates-not-released = Version { $to } is confirmed, but the lockout could not be released: { $error }

# What follows.
updates-lockout-stays = The lockout that the update has set stays: release it when the monitor is to be used again.
updates-lockout-of-others = Another client has locked it out meanwhile: that lockout stays.
updates-goes-on = What was received stays in the monitor: the same update goes on with it.
updates-goes-back = The new version is on trial: unless the same update is started before, the monitor goes back to the old one 180 s after its start.
updates-confirmed-yet = Version { $to } is confirmed.

# Why a run has ended.
updates-stopped = Stopped by { $user }.
updates-rights-lost = Ended: the rights of { $user } have ended.
updates-hub-ends = Ended: the hub ends.
updates-monitor-replaced = Ended: the hub has other monitors now.
updates-zone-alarm = Ended: zone { $zone } is not quiet any more.
updates-failed-at = { $monitor } was not updated; those after it are as they were.
updates-broken = Ended by a fault of the hub: its log says which.

# Updates: events.
updates-event-restarts = Restarts with version { $to } of its software, on trial.
updates-event-done = Software updated from { $from } to { $to }.
updates-event-confirmed = Software { $to } confirmed.
updates-event-failed = Software not updated: { $why }

# The Modbus server: events.
plug-listening = Modbus server { $name } listens: { $url }.
plug-not-listening = Modbus server { $name } does not listen: { $why }
plug-port-lost = The serial port was lost.
plug-heartbeat-lost = The heartbeat of { $master } ({ $from }) was lost: motions that it has started end, and it has to come back for its authority.
plug-not-closed = { $client } ({ $from }) was lost, and the monitor { $monitor } has not confirmed that { $valve } closes: Close is repeated each second, for ten minutes at most.
plug-not-stopped = { $client } ({ $from }) was lost, and the monitor { $monitor } has not confirmed that { $drive } stops: Stop is repeated each second, for ten minutes at most.

# The Modbus server: why a command is refused, by number.
plug-no-command = There is no command of this number. See the list of commands.
plug-no-monitor = There is no monitor of this number in this unit. Write 1 to the number in the register monitors.
plug-argument = An argument is outside of its range. See the list of commands.
plug-session = The session number is not the present one. Read session.number after each connection and each loss of the heartbeat, and write it with each command.
plug-heartbeat = The heartbeat is not alive. Change the register heartbeat more often than session.heartbeat_limit, and wait until session.live is 1.
plug-role = This master may only read, by hub.toml. Stop, Close and Lockout are taken all the same.
plug-held = Another client has authority. Ask for it with command 3, or wait until it is free.
plug-not-taken = No client has authority. Take it first with command 1.
plug-key = The key is not the one that is offered now. Read the key of this monitor and write it once.
plug-busy = The command before it has no result yet. Wait for it.
plug-sequence = This sequence number was used for another command. Write a new number with each command.
plug-refused = The monitor has refused; its result (§2/5) is in the register status.
plug-no-answer = The monitor has not answered. Check its power and line.
plug-unknown = Whether the monitor has done it is not known. Look at its state before sending it again.
plug-not-sent = It was not sent: there is no connection to the monitor.
plug-keep-out = Water could go into a keep-out of hub.toml. Turn the barrel away with the valves closed.
plug-too-fast = Too many commands. Send it again a second later.
plug-void = Not sent: heartbeat or authority was lost, or Stop came first.
plug-asked = Another client already asks for authority.
plug-late = There was no result in time; it may still be carried out. Look at the state of the monitor.
plug-ended = The motion was ended: by Stop, by another client or by the monitor. Start it with a new sequence number.
plug-hub = The hub could not do it. See its log.

# The Modbus server: commands, by number.
command-take = Take authority, if it is free.
command-release = Release authority.
command-ask = Ask the holder for authority; register authority shows when it is granted.
command-go-to = Go to: argument1 has a bit for each drive that moves (0 traverse, 1 elevation, 2 nozzle), argument2 traverse −3600…3600, argument3 elevation −900…1800, argument4 nozzle 0…1000.
command-open = Open valve argument1 (1 or 2), with the key of the monitor.
command-close = Close valve argument1 (1 or 2); 0: all of the monitor.
command-stop = Stop the monitor; monitor 0: all of the site.
command-lockout = Lock the monitor out; monitor 0: all of the site. Not released over Modbus.
command-deploy = Deploy the barrel.
command-stow = Stow the barrel.

# The Modbus server: registers.
map-version = Version of this map: another value is another map
map-life = Changes as long as the hub works
map-monitors = Number of monitors in this unit
map-site = Bit 0 a detector sees a fire, 1 a fire alarm waits, 2 any alarm waits for acknowledgement
map-quality = Bit 0 good: fresh and connected, 1 stale, 2 no connection, 3 never heard; not known: 4 traverse, 5 elevation, 6 nozzle, 7 pressure, 8 flow, 9 valves, 10 voltage
map-age = Age of the state, by a clock that does not jump; 65534: that or more, 65535: not known
map-mode = 0 not known, 1 stowed, 2 deploys, 3 stows, 4 by hand, 5 searches, 6 extinguishes, 7 program paused, 8 aligns, 9 locked out, 10 restarts
map-authority = Low byte: 0 no client holds it, 1 this master, 2 another; bit 8 the holder is lost, 9 a client asks for it, 10 this master asks for it
map-horizontal = Traverse, left is positive; −32768 not known
map-vertical = Elevation; −32768 not known
map-nozzle = Nozzle; −32768 not known
map-pressure = Pressure; 65535 not known
map-flow = Flow; 65535 not known
map-valves = Low byte valve 1, high byte valve 2: bit 0 open, 1 closed, 2 opens, 3 closes, 4 blocked, 5 fault, 6 there is one, 7 not known
map-fire = Bit 0 the detector sees a fire, 1 its alarm waits or is active, 15 not known
map-alarms = Low byte: number of alarms; high byte: the worst, 0 none, 1 fire, 2 high, 3 medium, 4 low
map-state = Bit 0 ready, 1 locked out, 2 water flows or may flow, 3 an alarm waits, 15 not known
map-motion = Three bits each for traverse, elevation, nozzle: moves, at the lower limit, at the upper limit; bit 15 not known
map-voltage = Supply voltage; 65535 not known
map-session = Number of this session, another one after each connection and each loss of the heartbeat
map-role = 1 observer, 2 operator
map-live = 1: the heartbeat of the master is alive
map-limit = The heartbeat changes within this time
map-losses = How often the heartbeat of this session was lost
map-heard = The heartbeat as last heard
map-profile = 1: this map
map-result-sequence = Sequence number of the command; 1 is the latest result
map-result-state = 0 none, 1 accepted, 2 done: the monitor has confirmed it, 3 refused, 4 no result in time
map-result-refusal = Number of the refusal; 0 none
map-result-command = The command
map-result-monitor = The monitor, from 1
map-result-status = Result of the monitor (§2/5), if it has refused
map-jog-sequence = Sequence number of the motion
map-jog-state = The worst of the drives
map-jog-drive = 0 none, 1 starts, 2 moves, 3 refused, 4 ended
map-key = The key for the next opening at this monitor; another one after each use, each loss of the heartbeat and each connection
map-heartbeat = Heartbeat of the master: to be changed within session.heartbeat_limit
map-new-sequence = A new number for each command
map-own-session = Number of the session: session.number
map-of-unit = The monitor, from 1
map-direction = 1 up, left or narrow, −1 the other way, 0 none; held as long as the heartbeat changes
map-command = The command; 0 none
map-argument1 = Bits of the drives, or the valve
map-argument2 = Traverse
map-argument3 = Elevation
map-argument4 = Nozzle
map-written-key = The key, to open
map-id = Id of the monitor in hub.toml
map-status-word = Status word of { $subsystem }, the high half first; all ones: not known
map-unit = Unit { $unit }, map version { $version }
map-columns = address | name | R/W | type | measure | meaning
map-commands = Commands
map-refusals = Refusals
map-numbers = number | meaning
vector-read-header = The master reads the header
vector-read-summary = The master reads the summary of the first monitor
vector-read-session = The master reads its session number
vector-beat = The master changes its heartbeat
vector-read-key = The master reads the key of the first monitor
vector-take = The master takes authority
vector-open = The master opens valve 1 with its key
vector-read-result = The master reads the results
vector-replay = The same opening again: the key has changed
vector-stop = The master stops everything
vector-part = A part of a block is refused: exception 3
vector-beyond = A register that is not there: exception 2

# The Modbus server: what is wrong with hub.toml.
check-servers = There are too many servers.
check-servers-remedy = Write 64 [[modbus_server]] at most.
check-server-name = `{ $name }` is no name of a Modbus server or client.
check-server-twice-remedy = Give each server a name of its own.
check-server-for-none = The server { $name } would answer no master: role is "none", and there is no client.
check-server-for-none-remedy = Add [[modbus_server.client]], or write role = "observer".
check-slow-heartbeat = With heartbeat_ms = { $ms } a motion ends later than 500 ms after its master, and no drive moves by hand: beats more than 300 ms apart move nothing.
check-slow-heartbeat-remedy = Write heartbeat_ms = { $ms } or less, or move with command 4 alone.
check-net = `{ $text }` is no address or network.
check-net-remedy = Write an address, 10.0.0.7, or a network, 10.0.0.0/24.
check-nets = The list is too long.
check-nets-remedy = Write 64 entries at most, or a network for several.
check-listen-name = `{ $host }` is no IP address to listen on.
check-listen-name-remedy = Write tcp://127.0.0.1:502, tcp://0.0.0.0:502 with allow, rtu+tcp://… or serial:///dev/ttyS1?baud=19200.
check-allow = { $address } can be reached from other machines, and Modbus has no login.
check-allow-remedy = Write allow = ["10.0.0.7"] with the addresses of the masters, or listen on 127.0.0.1.
check-allow-on-serial = The master of a serial line has no address.
check-allow-on-serial-remedy = Leave allow and from out.
check-server-port = The serial port is used by a monitor or a bus.
check-server-port-remedy = Give the master a port of its own.
check-server-same-line = The server { $name } listens there already.
check-server-same-line-remedy = Give each server a port of its own; several masters share one with [[modbus_server.client]].
check-server-monitor = There is no monitor { $id }.
check-server-monitor-remedy = Write the ids of monitors in this file, each once.
check-server-empty = `monitors` of the server { $name } is empty: its masters reach nothing, not even Stop.
check-server-empty-remedy = Write the ids of its monitors, or leave `monitors` out for all.
check-server-units = Eight monitors are a unit: the last one would be { $last }.
check-server-units-remedy = Write a smaller unit, or fewer monitors.
check-no-stop = { $name } does not reach the registers of commands: it cannot even stop a monitor.
check-no-stop-remedy = Let its registers contain { $first } to { $last }; observers may only stop, close and lock out there.
check-registers = The registers end before they begin.
check-registers-remedy = Write registers = [first, last].

# MQTT: events and states of the connection.
mqtt-not-yet = Not connected yet.
mqtt-connected = MQTT broker { $name } is connected: { $url }.
mqtt-not-connected = MQTT broker { $name } ({ $url }) is not connected: { $why }
mqtt-silent = The clients of { $client } ({ $from }) are silent: motions that they have started end, and they have to come back for their authority.
mqtt-failed = The connection to the broker failed: { $error }.
mqtt-no-answer = The broker does not answer within { $s } s.
mqtt-closed = The broker has closed the connection.
mqtt-sent-away = The broker has ended the connection: { $why }.
mqtt-not-authorized = The broker refuses this user and password, or this client id. Check user, password and client_id.
mqtt-old-version = The broker does not speak MQTT 5.
mqtt-turned-away = The broker refuses the connection: { $why }.
mqtt-why-forbidden = it does not allow this client
mqtt-why-busy = it is busy or not available
mqtt-why-ends = it is shutting down
mqtt-why-silence = it has heard nothing from the hub for too long
mqtt-why-taken-over = another client has connected under the same name
mqtt-why-limit = one of its limits was exceeded (size, rate, number or time)
mqtt-why-elsewhere = another broker is to be used
mqtt-why-unsupported = it does not take these topics, retained messages or this quality of service
mqtt-why-name = it does not take the name of this client
mqtt-why-protocol = it took a message for an error of the protocol
mqtt-why-unknown = it gives no reason
mqtt-no-subscription = The broker does not let this user subscribe to the topics of commands under { $prefix }: not even Stop would arrive. Check its access list.
mqtt-tls = TLS: { $error }.
mqtt-no-authority = This machine trusts no certificate authority. Give the one of the broker as ca.
mqtt-unknown-issuer = The certificate of the broker is signed by an authority that is not trusted. Give the right one as ca.
mqtt-other-name = The certificate of the broker is not for { $host }. Write the name in it into url.
mqtt-not-in-time = The certificate of the broker is not valid now. Check its dates and the clock of this machine.
sparkplug-waits = The primary host application { $host } is not there: nothing is published before it is.
sparkplug-dropped = MQTT broker { $name }: values that could not be sent were dropped, { $count } since the start of the hub.

# MQTT: why a command is refused, where Modbus has other words.
mqtt-no-command = There is no such command, or not for all monitors at once. See the list of commands.
mqtt-no-monitor = There is no monitor of this id here. See the ids in the topics of states.
mqtt-argument = An argument is missing, not for this command, or out of its range. See the list of commands.
mqtt-void = Not sent: the clients were silent, authority was lost, or Stop came first.
mqtt-role = Clients of this broker may only stop, close and lock out, by hub.toml.
mqtt-held = Another client has authority. Ask for it with ask, or wait until it is free.
mqtt-not-taken = No client has authority. Take it first with take.
mqtt-key = The key is not the one that is offered now. Read the key of this monitor and send it once.
mqtt-twice = This id was used for another command. Send a new id with each command.
mqtt-refused = The monitor has refused; its result (§2/5) is in status.
mqtt-ticket = The ticket is missing or older than 3 s. Send the latest one that the hub has published.
mqtt-retained = A retained message commands nothing. Send it without the retain flag.
mqtt-form = This is no command: JSON with id and command, and no field that is not in the list.

# MQTT: what is wrong with hub.toml.
check-brokers = There are too many brokers.
check-brokers-remedy = Write 8 [[mqtt]] at most.
check-broker-name = `{ $name }` is no name of a broker.
check-broker-twice-remedy = Give each broker a name of its own.
check-broker-same = The broker { $name } is the same, with the same client_id or prefix.
check-broker-same-remedy = Write one [[mqtt]] for it, or another client_id and another prefix.
check-broker-url = `{ $text }` is no broker.
check-broker-url-remedy = Write mqtts://broker.site:8883, or mqtt://127.0.0.1:1883.
check-broker-plain = The connection to { $host } is without TLS: the password, the tickets and the keys that open valves could be read on the way.
check-broker-plain-remedy = Write mqtts:// with ca, or plain = true if the network is for this alone.
check-client-id = `{ $text }` is no client id.
check-client-id-remedy = Write 1…64 letters, digits and signs, without spaces.
check-two-passwords = There are two passwords.
check-two-passwords-remedy = Write password or password_file.
check-password-alone = A password without a user.
check-password-alone-remedy = Write user.
check-password-file = { $path }: { $why }
check-password-file-remedy = Give the path of a file whose first line is the password; relative ones start from the folder of this file.
check-tls-unused = ca, cert and key are for mqtts:// alone.
check-tls-unused-remedy = Write mqtts:// in url, or leave them out.
check-cert-and-key = A certificate and its key go together.
check-cert-and-key-remedy = Write cert and key.
check-prefix = { $key } = `{ $text }` is no beginning of a topic.
check-prefix-remedy = Write 1…64 characters without + # $, and no / at the beginning, at the end or twice in a row.
check-broker-monitors = There are too many monitors for one broker.
check-broker-monitors-remedy = Write 256 monitors at most.
check-sparkplug-name = { $key } = `{ $text }` is no name of Sparkplug.
check-sparkplug-name-remedy = Write 1…64 characters without / + #; STATE is no group.
check-sparkplug-alone = { $key } is not for a broker with sparkplug: its topics are those of the format.
check-sparkplug-alone-remedy = Leave it out, or write another [[mqtt]] for our own topics.
check-topic-taken = The topic of monitor { $id } is one of the hub's own.
check-topic-taken-remedy = Give the monitor another id, or leave it out of `monitors`.

# OPC UA servers: their state.
opcua-not-yet = It is being started.
opcua-listening = OPC UA server { $name } listens: { $url }.
opcua-not-listening = OPC UA server { $name } does not listen: { $why }
opcua-failed = It failed: { $error }.
opcua-ended = It has ended.
opcua-no-certificate = Its certificate or key cannot be read or made. Check cert and key, or the folder of certificates.
opcua-silent = { $client } ({ $from }) is silent over OPC UA: motions that it has started end, and it has to come back for its authority.

# OPC UA: why a call is refused, where Modbus and MQTT have other words.
opcua-no-method = There is no such method, or not for all monitors at once.
opcua-argument = An argument is missing or out of its range. See the list of methods.
opcua-void = Not sent: the client was silent, authority was lost, or Stop came first.
opcua-role = This user may only stop, close and lock out here, by hub.toml or by the role.
opcua-held = Another client has authority. Ask for it with Ask, or wait until it is free.
opcua-not-taken = No client has authority. Take it first with Take.
opcua-key = The key is not the one that is offered now. Get it with GetKey and send it once.
opcua-refused = The monitor has refused; its result (§2/5) is in Status.
opcua-ticket = The ticket is missing or older than 3 s. Send the one that Alive has returned last.

# OPC UA: states of conditions.
opcua-enabled = Enabled
opcua-active = Active
opcua-inactive = Inactive
opcua-acked = Acknowledged
opcua-unacked = Unacknowledged
opcua-shelved = Shelved
opcua-unshelved = Not shelved

# OPC UA: what is wrong with hub.toml.
check-opcuas = There are too many OPC UA servers.
check-opcuas-remedy = Write 4 [[opcua]] at most.
check-opcua-name = `{ $name }` is no name of an OPC UA server.
check-opcua-listen-remedy = Write ADDRESS:PORT, as 127.0.0.1:4840, or 0.0.0.0:4840 with allow and host.
check-opcua-allow = { $address } can be reached from other machines.
check-opcua-allow-remedy = Write allow = ["10.0.0.7"] with the addresses of the clients, or listen on 127.0.0.1.
check-opcua-plain = Connections without security would reach { $address } from other machines.
check-opcua-plain-remedy = Leave plain out: what clients send is signed and encrypted. It is for 127.0.0.1 alone.
check-opcua-anonymous = Clients without a user could command monitors from other machines at { $address }.
check-opcua-anonymous-remedy = Write anonymous = "observer", or leave it out; users of the hub log in with their passwords.
check-opcua-host = `{ $text }` is no host.
check-opcua-no-host = { $address } does not say under which name or address clients reach the hub.
check-opcua-host-remedy = Write host = "hub.site" or host = "10.0.0.5".
check-opcua-monitors = There are too many monitors for one OPC UA server.
