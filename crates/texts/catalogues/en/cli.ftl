## What the program says on the command line, in the terminal and in its pictures.

# angle.rs
two-angles-expected = expected two angles separated by a comma, like `-20deg,3deg` or `-1200,180`
unit-mm = mm
nozzle-not-mm = `{ $text }`: the nozzle's position is a whole number of mm, like `30` or `30mm`
not-an-angle = `{ $text }` is not an angle: write arc-minutes (`1200`, `1200'`) or degrees (`20deg`, `12.5°`, `12°30'`), at most ±32767' (546°)

# cli.rs
one-of-names = expected one of { $names }
seconds-from = expected seconds, { $least }…3600

# cmd/backup.rs
subsystem-and-name-expected = expected a subsystem and a name like Vertical.Speed
file-exists = { $name } already exists; --force replaces it
parameters-saved = { $name }: { $count } parameters
parameters-not-set = ; not set: { $list }
parameters-missed = The monitor did not supply these parameters, so nothing was written: { $list }. See to the unit that has them, and repeat the command.
reading-parameters = reading parameters
no-differences = No differences.
heading-parameter = parameter
heading-monitor = monitor
parameters-absent = Skipped, this monitor does not have them: { $absent }
restore-interrupted = Interrupted. Repeat the command to continue from here.
restore-incomplete = Not everything was restored. Fix the cause and repeat the command: it writes only what is still missing.
other-subsystems =
    The file is from a monitor with other subsystems.
      file:    { $file }
      monitor: { $present }
    --except General.Chain keeps the monitor's own, --force writes those from the file.
other-address =
    The file is from a monitor with the address { $file }, this one has { $monitor }.
    --except General.Address keeps the monitor's own, --force writes the one from the file.
file-without-end = { $name }: a file of this format does not show where it ends. Make sure that it is whole.
parameters-differ = { $count } parameters differ
writing-parameter = writing { $name }
retrying-parameter = { $name }: busy or no answer, retrying
reading-back = reading back
nothing-to-write = Nothing differs: nothing to write.
takes-effect-after-restart = These take effect after `lafet restart`: { $list }
reads-back-as = reads back as { $values }
cannot-write-file = cannot write { $name }

# cmd/bus.rs
bus-addresses-expected = expected addresses like 1-8,129: monitors have 1…127, consoles 129…254
line-never-open = { $url }: { $why }. It was never open: check the URL, and that the port is there.
bus-needs-line = a bus needs a line; start `lafet sim` and give the URL it listens on.
bus-needs-addresses = bare records carry no addresses, so they cannot form a bus.
controller-not-console = role=active is for consoles; this is the controller.
cannot-listen = cannot listen on { $place }
addresses-lent = With --listen the addresses { $first }…{ $last } are lent to programs, so no console can have { $address }.
line-open = { $url }: open
line-retrying = { $url }: { $why }; retrying
listening-for-controller = listening for another controller, { $s } s
at-baud = {" "}at { $baud } baud
second-controller = { $url }: there is a controller on this bus: it is heard{ $at } (address { $controller }). A second one would transmit in its turns, so this one did not start, and sent nothing. Switch the other one off, or use the bus as a console (role=active and a src= of your own). --force starts all the same.
bus-at-other-speed = { $url }: devices transmit on this line{ $at } ({ $who }), not at the speed of the URL. The controller did not start, and sent nothing. Correct baud= in the URL; --force starts all the same.
bus-line-unreadable = { $url }: bytes arrive that were not asked for and that are no frames at any usual speed: noise. Check termination, bias and shield of the line; `lafet doctor` says more.
others-on-bus = { $url }: { $who } transmits without a controller. On a bus it needs role=active, or it disturbs the others.
address-lent = program at { $from }: lent the address { $address }
program-disconnected = the program with the address { $address } has disconnected
device-controller = controller
device-monitor = monitor { $a }
device-console = console { $a }
device-here = { $who }: here
device-dropped = { $who }: does not answer, dropped; probed each second
bus-counters = frames sent { $sent }, passed on { $passed_on }; requests of consoles { $requests }, answers { $answers }, repeated { $repeated }; strays { $strays }; of programs not sent { $dropped }

# cmd/bus_ask.rs
nobody-on-bus = No device answers on the bus.
nothing-asked-yet = Nothing has been asked yet.
no-controller-answers = No bus controller answers at { $endpoint } (address { $controller }, tries: { $tries }). On its own line it answers consoles only, each in its turn: add role=active and a src= of your own (129…254) to the URL. Programs at --listen of `lafet bus` need neither.
not-a-controller = The device that answers is not a bus controller.

# cmd/calibrate.rs
fitted-diameter = NozzleDiameter { $diameter_mm } mm: error over { $count } shots { $rms } m (root mean square), { $worst } m at most.
shot-range = range, m
shot-miss = miss, m
fitted-table = Correction table for { $distance_m } m, atm → degrees: { $degrees }
written-to-monitor = Written to the monitor.
nothing-written = Nothing was written.
no-diameter-fits = No outlet diameter fits these shots (the best one misses a shot by { $worst } m). Check pressure, elevation and range of each, and that the jet was the narrowest; nothing was written.
jet-too-short = The jet does not reach { $distance_m } m at any pressure: give a shorter --distance. Nothing was written.
shot-expected = expected pressure 1…25 atm, elevation −15…75 degrees, range 1…200 m: 7.9,15,39
millimetres-expected = expected millimetres, { $least }…{ $most }

# cmd/chip.rs
chip-reset = the program was reset
chip-crashed = the program failed and restarted; `lafet crash` shows what it recorded
chip-one-address = With --on qemu there is exactly one address to listen on: tcp://HOST:PORT, and not port 0.
chip-first-image = `{ $file }`: a new board first has an image for the board `{ $board }` that runs in slot A. `lafet image show` says what this one is for.
emulated-chip = the emulated chip

# cmd/conform.rs
no-such-test = No test is called `{ $wrong }`; `lafet conform --list` shows them all.
conform-takes-long = About ten minutes on a real monitor, with water and motion. Ctrl-C ends it and restores everything.
interrupted-restoring = Interrupted: restoring everything
restoring-everything = Restoring everything
conform-lost-monitor = The monitor no longer answers and may still move. Trying for up to { $seconds } s to reach it, stop it and restore everything; Ctrl-C twice gives up. If you see danger, use the emergency stop now.
cannot-write = cannot write
conform-given-up = Given up before the monitor was seen at rest. If it could be reached, Stop was sent as the last; not everything is restored, it may still move, and water may flow. If you see danger, use the emergency stop.
conform-cut-off = The line was cut, and the monitor was not seen at rest: it may still move, and water may flow. Use the emergency stop.

# cmd/coverage.rs
cannot-read-site = cannot read { $shown }
site-too-long = { $shown }: longer than 1 MiB; it is no file of a site

# cmd/plan.rs
cannot-read-drawing = the drawing { $shown } cannot be read

# cmd/decode.rs
neither-hex-nor-file = `{ $text }` is neither bytes in hexadecimal (like `ff c0 01 81`) nor a file
hex-ends = The input stops being hexadecimal at character { $offset }. Give --raw if it is not meant to be text.
cannot-read = cannot read { $path }
frame-broken = The frame at byte { $offset } is broken: { $why }. A receiver drops it silently.
no-frame = No frame found: a frame is FF C0 … C0 with a correct CRC (docs/protocol.md, link frame).

# cmd/demo.rs
demo-running =
    { $url }

    Simulated: a tank farm, three monitors, and a fire. No login is needed: other computers cannot reach this.
    Try in another terminal (Wireshark opens demo.pcapng as well: lafet dissector):
    { $list }Ctrl-C ends it. In the terminal: lafet demo --terminal

# cmd/dissector.rs
home-not-set = HOME is not set: print the dissector into a file of Wireshark's plugin folder
cannot-write-dissector = cannot write { $shown }
dissector-written =
    { $shown }
    Wireshark loads it at its next start.

# cmd/doctor.rs
severity-good = good
severity-warning = warning
severity-fault = fault
monitor-reports = The monitor reports:

# cmd/exercise.rs
expectations-failed = Expectations that do not hold: { $failed }.
the-simulator = simulator
simulator-failed = The simulator has failed.
monitors-count = { $monitors } monitor(s)
minutes-count = { $minutes } min
cannot-read-scenario = cannot read { $name }
no-such-scenario = There is no file `{ $name }`, and no scenario of this name. lafet has: { $known }.
cannot-write-path = cannot write { $path }

# cmd/image.rs
numbered-key-expected = expected the number of a key, 0 to 15, and its file, like 0=key0
board-name-expected = expected the name of a board: 1 to 16 visible ASCII characters
image-version-expected = expected one to four numbers of 0 to 65535 with dots between them, like 1.2.3
layouts-expected = expected the oldest and the newest layout of stored parameters that the program reads, like 1-2
key-made = { $file }: a new key. It signs what monitors take for their software: keep it where no one else can read it, and a copy in a safe.
public-key-other = { $file } has the public half of key { $id }, not of { $given }.
public-key-not-one = { $file } is no public key: `lafet image public` writes one.
key-not-one = { $file } is no key: it has { $is } bytes, not 32. `lafet image key` makes one.
image-too-long = { $file } is longer than { $mib } MiB: it is no image.
never-written-over = { $name } exists already and is never written over: choose another name.
image-not-one = { $file } is no image: `lafet image sign` makes one of a program.
image-other-format = { $file } is an image of another format than this lafet knows: use the version of lafet that made it.
image-empty = { $file } is empty, or larger than an image can be: nothing was signed.
image-revokes-itself = An image cannot revoke the key that it is signed with: sign it with another key.
image-malformed = { $file }: the header has a value that it cannot have. The file is damaged: copy it again.
image-cut = { $file }: behind the header there are { $is } bytes instead of { $size }. The file is not whole: copy it again.
image-changed = { $file }: the program is not the one that was signed (its SHA-256 differs). The file is damaged: copy it again.
image-signature-wrong = { $file }: the signature is not that of key { $key }. No board with that key takes this image.
image-other-key = { $file } is signed with key { $key }, and --public gives key { $given }: the signature was not checked.
image-board = board
image-version = version
image-size = bytes
image-slot = slot
image-slot-either = either
image-key = key
image-revokes = revokes keys
image-layouts = layouts
image-hash = SHA-256 of the program
image-signature = signature
image-signature-unchecked = not checked (--public)
image-signature-right = right
image-signature-bad = wrong
image-signature-other = not checked: another key

# cmd/install.rs
cannot-write-to = cannot write to { $shown }
pages-written = { $shown }: { $count } pages

# cmd/jog.rs
lease-expected = expected seconds, 0.05…2
jog-needs-keyboard = jog needs a keyboard: run it in a terminal. From a program use `lafet move` and `lafet stop`, or the library's `Drive::jog`.
all-motions-ended = All motions have ended.
drives-not-seen-at-rest = { $drives } may still move: not seen at rest. Use the emergency stop.
drives-stop-not-answered = { $drives } may still move: Stop is not answered yet. Trying for up to { $seconds } s; Ctrl-C gives up. If you see danger, use the emergency stop now.
drive-at-rest = { $drive } is at rest at { $at }.
drive-taken-over = { $drive }: { $by } controls the drive now.
drive-moves-in-spite = { $drive } is still moving in spite of Stop: use the emergency stop.
drive-not-moved = { $drive } was not moved: limits are off, and this monitor would not end the motion by itself if the connection failed. Switch the limits on, or set a time limit: `lafet param set general MoveTimeout 500`.
drive-state-unknown = Whether { $drive } is at rest is not known: use the emergency stop. { $error }
jog-keys = ←→ Horizontal  ↑↓ Vertical  + - Nozzle  space: Stop All  q: end

# cmd/limits.rs
limits-usage = Write `limits DRIVE` to see limits, `limits off|on|reject [DRIVE]` to switch them.

# cmd/motion.rs
done-then = done,
stopped-before = { $drive } stopped at { $show }, before { $to }. { $flags }
stopped-without-flag = { $who } has stopped; no flag says why. Another client may have sent Stop.

# cmd/param.rs
takes-effect-later = {" "}Takes effect after `lafet restart`.
value-stored = stored
value-accepted = accepted, not confirmed (the monitor has not reported it as stored: it may be moving, or not report this at all)
value-in-force = in force, not stored
memory-not-written = The monitor could not write its memory (ConfigWriteFault): the value is lost at the next reset. Check the supply and try again.
values-allowed = { $name }: allowed are { $range }. { $text }
no-parameters = This subsystem has no parameters.
no-values = (empty)
read-only = read-only
default-value = default { $value }
after-restart = after restart
may-be-on-remote-unit = may be on a remote unit
whole-number-expected = expected a whole number, decimal or 0x

# cmd/ports.rs
no-serial-port = No serial port found. Plug the adapter in; `dmesg` shows whether it is recognised.
port-free = free
port-no-permission = no permission
port-in-use-by = in use by

# cmd/program.rs
program-number-expected = expected a number, 0 to 7
the-trajectory = trajectory
the-program = program
program-is-empty = empty
program-centre = centre { $h } horizontally, { $v } vertically
program-sector = sector { $width } wide, { $height } high, a line every { $step }°
program-nozzle = nozzle { $nozzle } mm
aimed-straight = aimed straight
fire-away = fire { $metres } m away
trajectory-point = { $number }: { $h } { $v }, { $distance } m, stays { $seconds } s

# cmd/quench.rs
corrections-too-few = --corrections needs at least two values: with one it would be a distance (§3.14)
no-such-program = --program { $program }: programs are numbered 0 to 7
program-empty = Program { $program } is empty: the barrel would deploy and aim at 0°, 0° (or at --centre), with no sector and no correction for the distance. Nothing was sent. See `lafet program list`, store it with `lafet program set { $program } …`, or add --empty.
request-done = { $request }: done
point-expected = expected horizontal,vertical,metres,tenths of a second, like 20deg,-2deg,25,10

# cmd/record.rs
recording-extension = end the name in .mcap or .pcapng
recorded = { $name }: { $frames } frames, { $bytes } bytes of the line
polls-withheld = A controller gives access on this line, so no requests are sent: what others send is recorded. With role=active and a src= of your own in the URL the monitor is polled too.
cannot-listen-tap = cannot listen on { $address }
connect-tap = Connect the program to tcp://{ $bound } instead of { $url }.
reconnecting = { $url }: { $error }; reconnecting
tap-goes-on = Nothing more is recorded; the tap goes on passing everything.

# cmd/replay.rs
cannot-read-recording = cannot read { $name }
replay-waits = tcp://{ $bound }: the replay begins with the first connection

# cmd/scan.rs
hosts-expected = expected 192.168.1.0/24 (up to /20), 192.168.1.10-40, an address or a name
scan-addresses-expected = expected addresses like 1-127, at most 254
nothing-to-scan = framing=records leads to one monitor without an address: there is nothing to scan.
probing-addresses = probing addresses
noise-before-scan = Bytes arrive on this line that are not frames: devices at another speed (baud=), or noise. A probe could collide with another client's Stop, so nothing was probed. `lafet doctor` says more; --insist probes anyway.
others-before-scan = Others talk on this line ({ $who }); a probe could collide with another client's Stop, so nothing was probed. --insist probes anyway; a bus controller knows the addresses present.
answers-bare-records = bare records
open-without-monitor = open, but no monitor answers
no-open-port = No open port.
ports-examined = ports examined: { $done } of { $all }, { $seconds } s
bus-controller = bus controller
console = console
crc32c-only = , CRC-32C only
two-have-address = , TWO devices have this address
unit-ms = ms
others-after-scan = Others talk on this line ({ $who }): answers may be missing here.
broken-frames = Broken frames: { $broken }. `lafet doctor` says more.
nobody-at-addresses = No device answers at addresses { $first }…{ $last }. `lafet doctor` looks for the cause.
no-monitor-found = No monitor found.

# cmd/seek.rs
aligned = Aligned: the detector points { $horizontal }' left and { $vertical }' up.
no-fire-spots = No fire spots.
seek-deploying = deploying
seek-looks-at = looking at azimuth { $horizontal }, elevation { $vertical }

# cmd/send.rs
not-records = `{ $text }` is not a sequence of records: { $reason }

# cmd/serve.rs
one-of-words = one of { $words }
config-good = { $file }: no errors; monitors: { $count }; listens on { $listen }
no-config = There is no configuration: neither { $first } nor { $second } exists. To create one: lafet serve --example > hub.toml. To try it without monitors: lafet demo.
cannot-read-config = cannot read { $file }
audit-good = { $entries } entries, none changed, none missing up to the last one, whose hash is { $head }
audit-changed = Entry { $bad } is not as written: it was changed, or an entry before it was removed.

# cmd/service.rs
lockout-stored = The lockout is stored: after each restart and loss of power the monitor is locked out, until it is released.
lockout-unconfirmed = The lockout is in force. The monitor has not reported it as stored, so a loss of power may end it: send it once more.
lockout-not-stored = The lockout is in force and not stored: the next restart ends it.
release-stored = The release is stored: after a restart the monitor is not locked out.
release-unconfirmed = The monitor is released. It stores that within a moment and does not report it: if its power fails before, it starts locked out, and has to be released once more.
release-not-stored = The monitor is released, and that is not stored: after the next restart it is locked out again.
no-crash-data = No crash data.
no-hardware-fault = No hardware fault is recorded.
unknown-bits = bits that are not known
crash-running = running

# cmd/shell.rs
motion-continues = The motion continues.
line-dropped = Not run, as it was typed before the stop: { $line }
script-line = Line { $number }: { $line }
shell-in-shell = The shell is already running.
monitor-lost = { $name } does not answer{ $why }
monitor-back = { $name } answers again: { $state }.
shell-help =
    help: the commands of lafet, without the URL. Tab completes. exit quits.
    stop and Ctrl-C stop whatever moves.
option-at-start-only = --{ $name } is set when the shell starts: `exit` and restart it.
line-held-by-shell = The shell holds this line, and the command needs it exclusively: run it without the shell.

# cmd/sim.rs
nothing-burns = nothing burns; --fire az=30,range=25 lights a fire 25 m away, 30° to the left
radio-needs-frames = { $place }: --radio needs frames, so that losses are noticed.
radio-expected = `{ $part }`: expected rate=300…10000000, latency=0…10000 (ms), loss=0…1, errors=0…1
cannot-listen-sim = cannot listen on { $place } (is another simulator running? port 0 takes a free one)
cannot-keep-memory = cannot keep the memory in { $path }
not-a-memory = { $path } is not the memory of a simulated monitor, is damaged, or comes from an earlier version. Remove it to start with a new one, or give another file.
own-key-of-simulator = Key 15 is the simulator's own: give --update-key a number of 0 to 14.

# cmd/teach.rs
deployer-without-limits = The end positions of Deployer are set by its switches: it has no limits to set.
old-limits-again = { $drive } keeps its old limits; they are on again.
new-limits-already = { $drive }: the new limits are in force: { $range }. They are on.
limits-not-read = { $drive }: its limits are on. Which ones could not be read: see `lafet limits { $drive }`.
limits-are-off = { $drive }: its limits are { $range }. They are off now: only the motor's overload protection stops it at the end of its travel.
teach-keys = Move { $drive } to its { $word } limit. Enter takes it, s keeps the old one, q gives up.
limits-are-on = { $drive }: limits are on: { $range }.
limit-taken = { $drive }: { $word } limit { $at }. Its limits are { $range }.
limit-taken-later = { $drive }: { $word } limit { $at }, in force after `lafet limits on { $drive }`.

# cmd/throw.rs
throw-step = --step: at least { $step_least }°, and at most { $lines_max } lines of the table
throw-elevation = elevation
throw-middle = middle, m
throw-greatest = greatest, m
throw-top = top, m
throw-flight = flight, s
throw-aside = aside, m
throw-simulator = simulator: middle, m
throw-legend = Middle: of the wetted ground; greatest: where the outermost water lands; top: the highest water. In brackets: the band in which the published rows lie that were kept out of the fit (docs/physics.md).
throw-simulator-legend = The simulator and `lafet coverage` have a more coherent jet than monitors as their makers state them: its middle is the last column.
nozzle-of-monitor = Monitor
smooth-bore = Smooth bore
wind-from = wind of { $wind_mps } m/s from { $wind_from_deg }° off the jet
still-air = still air
throw-conditions = { $kind }: { $flow } l/s at { $pressure_mpa } MPa, outlet { $outlet } mm, nozzle at { $nozzle_mm } mm, { $height_m } m above the ground, { $wind }
wind-left = left
wind-right = right
flow-expected = expected a flow like 20 (l/s) or 1200l/min
pressure-expected = expected { $least }…{ $most } MPa, or { $bar_least }…{ $bar_most } bar like 8bar
elevation-expected = expected degrees like 30, or 10..75 with the lower one first
nozzle-kind-expected = expected monitor or smooth

# cmd/top.rs
size-expected = expected columns and lines, like 80x24
top-needs-terminal = top needs a terminal. `lafet top --once` prints one picture as text, or with --json one object per monitor; `lafet watch --json` repeats.
state-not-known = the state is not known
cannot-draw = cannot draw on this terminal
stop-not-sent = Stop All NOT sent: no link
stop-not-answered = Stop All was sent and not answered. If you see danger, use the emergency stop now.

# cmd/tune.rs
tune-not-deployer = Deployer goes from switch to switch: there is nothing to tune.
tune-runs-already = Another lafet tune moves the drives of this monitor. Wait until it has ended, or end it there.
tune-put-back = An earlier tuning of { $drive } was cut off: { $name } { $from } → { $to }, as it was before.
tune-not-put-back = { $drive } may still have the values of the measurement. They are noted: the next lafet tune puts back those before.
tuned-drive = drive
tuned-lag = StopLag, ms
tuned-error = error at rest

# cmd/update.rs
update-runs-already = Another lafet update of this monitor runs. Wait until it has ended, or end it there.
update-two-images = Two images have to be of one version for one board, one linked for slot A and one for slot B.
update-sending = sending: { $percent } % of { $size } bytes
update-sending-left = sending: { $percent } % of { $size } bytes, { $left } left
update-verifying = the monitor verifies what it has received
update-committing = asking the monitor to try the new version
update-committed = committed: the monitor tries the new version
update-restarting = waiting for the monitor to come back
update-on-trial = the new version runs, on trial
update-confirming = confirming
update-confirmed = confirmed
update-done =
    { $from } → { $to }, confirmed.
    The monitor is still locked out: `lafet lockout off` releases it.
update-done-trial =
    { $to } was on trial and is confirmed.
    The monitor is still locked out: `lafet lockout off` releases it.
update-interrupted = Ended here: { $far }. Nothing was undone: the same command goes on.
update-interrupted-trial = Ended here: { $far }. Unless the same command is run again before, the monitor goes back to its old version 180 s after its start.
update-goes-on = How far it was: { $far }. The same command goes on.
update-note-damaged = { $file } is no whole note of an update. Nothing depends on it: it is replaced.
update-note-unreadable = The monitor has an image committed or on trial, and what confirms it cannot be read from { $file }. Wait until the monitor has gone back by itself, 180 s after its start, or switch its power off and on. Then repeat the command.
update-word-elsewhere = The monitor has an image committed or on trial that was not sent from here, so nothing here confirms it. Run the command where it was sent from, or wait until the monitor has gone back by itself, 180 s after its start.
update-other-image = The monitor has another image committed or on trial, which was sent from here. Run the command with that image to confirm it, or wait until the monitor has gone back by itself, 180 s after its start.
update-row-version = version
update-row-slot = slot
update-row-running = runs
update-row-phase = update
update-row-image = hash
update-row-order = last order
update-row-trial = last trial
update-row-pending = commit
update-row-lost = confirmed
update-in-service = in service
update-is-on-trial = on trial: unless it is confirmed, the next start goes back
update-phase-idle = none since the start
update-phase-receiving = receiving: { $done } of { $size } bytes are there
update-phase-verifying = verifying { $size } bytes
update-phase-verified = verified, not committed
update-phase-committed = committed: the next start tries it
update-phase-unknown = phase { $n }, which this lafet does not know
update-digest-running = { $hash }…, of the image that runs
update-digest-received = { $hash }…, of the image that is received
update-order-done = carried out
update-order-waits = waits
update-order-refused = { $why } (reason { $n })
update-trial-failed = not confirmed, so the monitor went back
update-commit-pending = not taken back yet: the lockout is not released before
update-confirmed-lost = the version that was confirmed last does not verify any more, an older one runs: send it again
update-site-hub-runs = The hub of { $file } runs, or another `lafet update --all` of this file: it has the links to the monitors. Update them in the console of the hub, or stop it first.
update-site-hub-hidden = Whether a hub uses { $folder } cannot be seen (run the command as the user of the hub, or as root)
update-site-unknown = The configuration has no monitor { $id }. It has: { $known }.
update-site-not-ready =
    Nothing was changed, as these monitors cannot be updated now:
    { $lines }
update-site-no-general = General does not answer with its state. See `lafet doctor`.
update-site-program = A program runs: end it (`lafet stop control`).
update-site-search = A search or an alignment runs: end it (`lafet stop detector`).
update-site-newer = It runs { $version }, which is newer than the image. The monitor takes an older one only while the button at its board is pressed: update it alone.
update-site-beside-locked = Zone { $zone }: { $id } serves it too and is locked out. Two monitors of a zone are not taken out of service at once: release { $id } first.
update-site-beside-silent = Zone { $zone }: { $id } serves it too, and it is not known that it is in service. { $error }
update-site-ready = { $id }: ready, version { $version }
update-site-locking = { $id }: the monitor is being locked out
update-site-releasing = { $id }: the lockout is being released
update-site-not-locked = The monitor does not report the lockout that it was sent.
update-site-still-locked = The release was sent, and the monitor is still locked out: another client may have locked it out.
update-site-line-given = It is updated. Its line was given to another program meanwhile, which may have locked it out as well: its lockout was not released.
update-site-one-done = { $id }: { $from } → { $to }, confirmed; { $lockout }.
update-site-trial-done = { $id }: { $to } was on trial and is confirmed; { $lockout }.
update-site-same = { $id }: { $to } is running already. Nothing was changed.
update-site-released = the lockout was released
update-site-locked-before = locked out as before
update-site-locked-here = locked out by this command
update-site-unlocked = not locked out
update-site-seen = { $id }: version { $version }, { $running }; update: { $phase }; { $lockout }.
update-site-unseen = { $id }: its state cannot be read now; { $lockout }.
update-site-go-on = To go on, run the same command with `--only { $id }`, then `lafet -c "{ $url }" lockout off` (a lockout that the command finds it leaves), then the same command for the others.
update-site-summary = Done: { $done }. Not touched: { $rest }.
update-site-untouched = Ended before anything was changed.
update-site-done = Monitors that were to be updated: { $count }. All of them run { $version }.

# cmd/watch.rs
enter-ends = Enter ends
ctrl-c-ends = Ctrl-C ends

# connect.rs
listening-first = listening to the line before it is used, { $s } s
port-awaited = { $port } is in use by { $program } ({ $pid }). Waiting for it, { $s } s at most. If that program keeps it: stop the monitor there, or end it (`kill { $pid }`); the emergency stop of the monitor waits for nothing.
port-awaited-of = { $port } is in use by another program, which this user may not see. Waiting for it, { $s } s at most. If that program keeps it: stop the monitor there; the emergency stop of the monitor waits for nothing.
port-given = { $url }: { $program } ({ $pid }) had to send at once, Stop for example, and got the port. Nothing was sent: look what it was for, then start this command again.
port-given-away = { $url }: given to { $program } ({ $pid }), which has to send at once, Stop for example. This command starts again when that program has closed the port.
port-given-often = { $url }: other commands had to send at once { $times } times, and got the port each time. Look what they are for, then start this command again.
line-at-other-speed = { $url }: others transmit on this line at { $baud } baud ({ $who }), not at { $own }. Nothing was sent: it would reach no device and disturb theirs. Write baud={ $baud } into the URL; where there is a controller, also role=active and a src= of your own.
controller-on-line = { $url }: a bus controller transmits on this line. Devices of its bus transmit in the turns that it grants, so nothing was sent. Write role=active and a src= of your own (129…254) into the URL, or disconnect the controller; --insist sends all the same. Stop, Close and Lockout on are always sent.
line-not-frames = { $url }: bytes arrive that were not asked for and that are no frames ({ $bytes } of them): devices at a speed that is not in the URL, or noise. Nothing was sent: it could collide with a Stop of others. `lafet doctor` says more; --insist sends all the same. Stop, Close and Lockout on are always sent.
others-on-line = { $url }: others transmit on this line ({ $who }). The tests need it for themselves, so nothing was sent. Switch the others off, or disconnect them; --insist sends all the same, and both may be disturbed.
waiting-for-late-answers = The monitor does not answer frame numbers, so late answers cannot be distinguished from current ones: waiting { $s } s. late= in the URL sets how late they can be; late=0 if no other program uses this connection.
which-monitor = Which monitor? Give its URL with -c (or in LAFET_CONNECT), for example `-c tcp://192.168.1.50:10485?addr=1`, `-c serial:///dev/ttyUSB0?baud=19200`, or `-c sim:` for a simulated one.
sim-options = sim: does not support `{ $key }={ $value }`. Supported: profile={ $profiles }, seed=7, speed=20, fire=az=30,range=25,size=1.5 and addr=1.

# coverage/file.rs
site-needs-monitor = at least one [[monitor]] is needed
coverage-no-places = The hub knows no places: give its monitors `at = [east, north]`, `heading` and `height`.
site-needs-site = [site] is needed
tables-at-most = { $count } tables, { $most } at most
monitors-with-one-name = two monitors are called `{ $name }`
body-needs-size = `radius` (a cylinder) or `size = [length, width]` (a box) is needed

# coverage/picture.rs
picture-legend = jets within 90 % of the throw, worst wind; circles: weakest points
jets-none = no jet
jets-one = one
jets-two = two
jets-three = three or more

# coverage/report.rs
coverage-shares = Share of the cells with one jet / with two, and the fewest jets on a cell (90 %):
coverage-head = { $name }: { $east } × { $north } m, cells of { $cell } m, { $protected } of them to protect; { $count } monitor(s), { $flowing } flow together at { $pressure } MPa
coverage-wind-from = from { $from }°, { $speed } m/s
coverage-wind = wind
coverage-reached = reached
coverage-90 = 90 % of the throw
coverage-75 = 75 % of that in still air
coverage-fewest = fewest
weakest-points = Weakest points (90 %):
weakest-fewest = { $fewest } jet(s) in the worst wind
weakest-still = { $still } in still air
lost-monitor-costs = What a lost monitor costs (90 %, worst wind):
cells-without-jet = { $none } without a jet
cells-with-one = { $one } left with one

# decode/mod.rs
probe-frame = (probe)
record-cut-short = record cut short
before-byte = before byte
count-skipped = bytes skipped
count-crc = CRC errors
count-escapes = escape errors
count-too-long = frames too long
count-cut-short = frames cut short
decode-summary = { $bytes } bytes: frames: { $frames }, records: { $records }, records cut short: { $malformed }, bytes skipped: { $bytes_skipped }{ $why }

# demo/drawing.rs
cannot-write-picture = cannot write the picture

# demo/picture.rs
unit-s = s
q-quits = q quits
picture-monitor = {" "}monitor{" "}
picture-water = { $pressure } atm  { $flow } l/s{" "}
unit-a = A
picture-fire-spot = fire spot { $number }: { $azimuth }, { $elevation }, brightness { $brightness }
picture-exchange = {" "}requests and answers{" "}

# demo/plan.rs
plan-title = {" "}plan, m{" "}
plan-out = {" "}out

# demo/script.rs
demo-standby = standby
demo-standby-done = Standby: the barrel is stowed, the valves are closed.
demo-found-nothing = The search has found nothing: is the fire within ±60° and in sight?
demo-fire-burns = A fire still burns.
demo-search = search
demo-search-endless = The search does not end.
demo-quench = quench
demo-no-flames = No more flames there.
demo-closing = It does not go out: closing.
demo-valve-open = Valve1 does not close.
demo-not-put-out = The fire was not put out.
demo-distance-seen = The foot of the flame is seen at { $angle } from { $height_m } m above ground: { $height_m } / tan = { $estimate_m } m away.
demo-distance-told = An edge at { $angle } gives no distance; the operator's map says { $told_m } m.
demo-stowing = stowing
demo-not-stowed = The barrel does not stow.
demo-standby-again = Standby again.

# demo/stage.rs
no-port-free = no port of the loopback is free
stage-fire-breaks-out = fire{ $fire } breaks out, azimuth { $azimuth }°, { $range } m away
stage-water-reaches = water reaches the fire{ $fire }
stage-fire-out = the fire{ $fire } is out
stage-fire-again = the fire{ $fire } flares up again
stage-jet-begins = the jet begins
stage-jet-ends = the jet ends
stage-water-in-barrel = WATER IN THE FOLDED BARREL

# demo/summary.rs
never = never
time-to-detect = time to detect
time-to-water = time to water
time-to-out = time to out
time-to-standby = standby again
water-used = water used
unit-litre = l
requests-and-answers = requests / answers
demo-summary = Summary (simulated time from the lighting of the fire, seed { $seed }): fires out: { $out } of { $fires }

# describe.rs
value-invalid = invalid
unit-v = V
unit-atm = atm
unit-lps = l/s
unit-mmps = mm/s
unit-degps = °/s
place-horizontal = horizontal
place-vertical = vertical
place-nozzle = nozzle
place-deployer = deployer
place-housing = housing
spot = fire spot
spot-azimuth = azimuth
spot-width = width
spot-height = height
spot-brightness = brightness

# failure.rs
requests-refused = { $count } requests refused; the first: { $first }
interrupted = Interrupted.
answers = answers
exchange-request = request
exchange-answer = answer{" "}
why = Why
try = Try
standard-streams = standard input or output

# hub/faults.rs
part-vertical = Elevation drive
part-horizontal = Azimuth drive
part-nozzle = Nozzle
part-deployer = Deployer
part-valve1 = Valve 1
part-valve2 = Valve 2
part-box = Control box
part-buttons = Button post
part-ext-buttons = Remote button post
part-water = Water
part-detector = Detector
part-monitor = Monitor
fault-temperature-dead = Temperature sensor does not answer
fault-temperature-frozen = Temperature reading does not change
fault-temperature-drift = Temperature reading drifts up, 0.1 °C a second
fault-heater = Heater's circuit is broken
fault-button-short = short circuit
fault-button-break = broken wire
fault-button-bounce = contact bounces and blips
fault-button = Button { $button }: { $what }
fault-motor-open = Motor circuit is broken
fault-jam = Jammed: does not move
fault-power-stage = Power stage is dead, undiagnosed
fault-runaway = Power stage is shorted: runs by itself
fault-friction = Friction: draws too much
fault-flicker = Friction, and a current reading with gaps
fault-lag = Speed follows late, 300 ms
fault-dead-band = Does not turn below 1 °/s or 1 mm/s
fault-droop = Speed yields to the load, 0.4 °/s for each A
fault-backlash = Play of 12′ or 1 mm in the gear
fault-stiff = Stiff grease: draws more
fault-encoder-dead = Position reading does not change
fault-encoder-reversed = Position counts the wrong way
fault-encoder-fast = Position counts four times too much
fault-encoder-jump = Position has jumped by 20° or 15 mm
fault-encoder-noise = Position is noisy, ±2′ or ±1 mm
fault-encoder-fault = Position sensor reports a fault
fault-speed-dead = Speed sensor reads zero
fault-speed-reversed = Speed sensor has the wrong sign
fault-speed-fault = Speed sensor reports a fault
fault-min-switch = Lower, right or stowed end switch stuck on
fault-max-switch = Upper, left or deployed end switch stuck on
fault-min-bounce = Lower, right or stowed end switch bounces and blips
fault-max-bounce = Upper, left or deployed end switch bounces and blips
fault-open-relay = Relay is welded: opens by itself
fault-valve-jam = Plug is stuck
fault-open-switch = Circuit of the switch «open» is broken
fault-close-switch = Circuit of the switch «closed» is broken
fault-close-stuck = Switch «closed» is stuck on
fault-blocked = Hardware block is on
fault-open-bounce = Switch «open» bounces and blips
fault-close-bounce = Switch «closed» bounces and blips
fault-blocked-bounce = Contact of the hardware block bounces
fault-unit-offline = Remote unit does not answer
fault-unit-lossy = Remote unit: half of the exchanges are lost
fault-unit-protocol = Remote unit breaks its protocol
fault-unit-watchdog = Remote unit was reset by its watchdog
fault-remote-no-answer = Remote parameters: no answer
fault-remote-incomplete = Remote parameters: incomplete
fault-remote-bad-id = Remote parameters: bad id
fault-remote-bad-value = Remote parameters: bad value
fault-remote-error = Remote parameters: error
fault-pressure-break = Pressure sensor: broken wire
fault-pressure-short = Pressure sensor: short circuit
fault-pressure-frozen = Pressure reading does not change
fault-pressure-drift = Pressure sensor drifts down, 20 µA a second
fault-flow-frozen = Flow reading does not change
fault-flow-drift = Flow meter drifts up, 1 l/s in five seconds
fault-pump-off = The pump gives nothing
fault-pump-weak = The pump gives a quarter of its pressure
fault-supply-low = Supply voltage a third too low
fault-supply-high = Supply voltage a third too high
fault-supply-dip = Supply dips for 0.2 s when a motor starts
fault-supply-sag = Supply sags as long as a motor runs
fault-humidity = Humidity sensor does not answer
fault-detector-dead = Detector does not answer
fault-detector-saturated = Detector is saturated: light everywhere
fault-dirty-lens = Detector's glass is dirty
fault-memory-read = Memory cannot be read
fault-memory-write = Memory cannot be written

# hub/mod.rs
folder-shared = { $folder } can be written by other users of this machine and contains files that are not the hub's. Set data to a folder of its own.
folder-in-use = Another hub uses { $folder }: stop it, or set another data folder for this one.
cannot-open-storage = cannot open the hub's storage
hub-failed = a part of the hub has failed, as the log says: it has ended
cannot-listen-hub = cannot listen on { $listen }
no-users-yet =
    There are no users yet. Create the first administrator here, once:
      { $link }
state-lost =
    The state of the hub is not as it was saved:
      { $list }
    Find out why, and restore a copy of the whole folder if there is one. To continue without it, which will be recorded: lafet serve --accept-lost { $words }

# hub/training.rs
kind-monitor = monitor
fire-kind-unknown = `{ $kind }` is none of pool, pile, spray; or too much burns.
kind-fire = fire
kind-fault = fault
kind-scenario = scenario
kind-place = place
side-north = North
side-north-east = North-east
side-east = East
side-south-east = South-east
side-south = South
side-south-west = South-west
side-west = West
side-north-west = North-west
side-middle = Middle
no-such-one = There is no { $kind } `{ $name }`.

# interrupt.rs
cannot-catch-signals = cannot catch signals

# serve/listener.rs
listener-expected = expected tcp://HOST:PORT (?framing=records for bare records), udp://HOST:PORT or pty, each also with radio+ before it; port 0 takes a free one

# shell/complete.rs
leave-shell = Leave the shell
explain-command = Explain a command

# shell/words.rs
quote-open = A quote is not closed.

# simulator.rs
speed-expected = expected a factor greater than 0, at most { $speed_max }
profile-expected = expected one of { $known }
no-such-fault = no such fault; docs/faults.md lists them: horizontal-lag, valve1-jam, pump-off …
no-such-fault-but = no such fault; expected one of { $known }
fire-expected = az=DEGREES (left is positive) and range=METRES, and optionally size=METRES, growth=M/S, reignites=1, lit=0, class=solid|hydrocarbon; for example az=30,range=25,size=1.5

# surroundings.rs
wind-expected = expected metres per second forward and left, each at most { $wind_max_mps }: -5,0 is a head wind
gusts-expected = expected a share of the mean wind, 0 to { $gusts_max }; 0.15 is open country
glare-expected = az=DEGREES (left is positive, -360 to 360), el=DEGREES (-90 to 90), size=DEGREES (above 0, to 90) and brightness=N (1 to 1000000): az=30,el=5,size=0.5,brightness=2000
wall-expected = from=DEGREES and to=DEGREES (its right and left end, -180 to 180), range=METRES and height=METRES (above 0): from=-10,to=10,range=15,height=3
write-instead = write { $form }

# top/detail.rs
top-problems = Problems
stale-for = STALE,{" "}
stale-ago = ago

# top/frame.rs
page-list = 1 list
page-monitor = 2 monitor
page-link = 3 link
list-selected = {"  "}{ $selected } of { $count }
list-alarms = {"  "}alarms: { $alarms }
list-stale = {"  "}stale: { $stale }
top-keys = {" "}↑↓ monitor  Tab page  1 2 3  PgUp PgDn scroll  ? keys  q quit
top-stop-key = {" "}s  STOP ALL: { $name }{" "}
keys-title = {" "}keys{" "}
keys-help =
    s            Stop All for the selected monitor, on every page
    ↑ ↓  k j     previous, next monitor
    Tab Shift+Tab  next, previous page
    1 2 3        list, monitor, link;  Enter: monitor,  Esc: list
    PgUp PgDn    scroll what does not fit
    q  Ctrl-C    quit; this stops nothing

    !  warning   !! alarm   grey: stale, may have changed since
    Stop is the only request of this screen that changes anything.

# top/link.rs
chart-title = round trip, a column a second; the longest
link-connecting = connecting
link-up = up
link-down = down
figures-later = The first figures appear after a second.
last-second = last second
link-of-all = link
frames-unanswered = frames sent without an answer
frames-sent = frames sent
frames-received = frames received
answers-accepted = answers accepted
frames-with-errors = frames with errors (CRC, form)
answers-not-in-time = answers not in time
frames-repeated = frames repeated
late-answers = late answers
answers-twice = answers twice
frames-of-others = frames of other devices
answers-to-nothing = answers to no request
collisions = collisions, echoes missing
reconnections = reconnections
round-trip = round trip:
trip-last = last
trip-average = average
trip-min = min
trip-max = max

# top/list.rs
list-problems = problems
column-state = state
column-horizontal = horiz.
column-vertical = vert.
column-age = age
no-problems = None: no flag reports a fault.

# top/scene.rs
scene-no-link = no link
scene-no-answer = no answer
scene-locked-out = LOCKED OUT
scene-deploying = deploying
scene-paused = paused
scene-seek = seek
scene-aligning = aligning
scene-moving = moving
scene-stowed = stowed
scene-deployed = deployed
scene-in-between = in between
scene-ready = ready

# top/words.rs
scene-stale = stale
unit-min = min
unit-h = h

# aside.rs
lines-left-out = Lines left out here, because they were not read in time: { $count }

# undo.rs
interrupted-while = Interrupted: { $words }
risk-barrel = the barrel may still move
risk-program = the extinguishing program may still run, and the barrel may still move
risk-valve-moves = { $valve } may still open or close
risk-drives = { $drives } may still move
risk-valves-open = { $valves } may be open, and water may flow
risk-limits-off = the limits of { $drives } may still be off
undo-tries =
    { $error }
    { $risk }. Trying for up to { $seconds } s to reach the monitor and send { $words }; Ctrl-C gives up. If you see danger, use the emergency stop now.
stop-tries =
    { $error }
    Trying for up to { $seconds } s to reach the monitor and send { $words }; Ctrl-C gives up. If you see danger, use the emergency stop now.
undo-done = { $words } was sent; at rest now.{ $state }
undo-leaves-open = { $valve } is not closed, and water may flow. To close it: lafet close { $name }
undo-not-at-rest = { $words } was answered, but it is not at rest: { $state }. { $emergency }
undo-not-seen = { $risk }: it was not seen at rest after { $words }. { $emergency }{ $why }
undo-gave-up = Gave up before it was seen at rest. { $risk }. { $emergency }
use-emergency-stop = Use the emergency stop.

# help/mod.rs: the frame of the help of a command. In English clap has its own words.
heading-usage = Usage:
heading-commands = Commands
heading-arguments = Arguments
heading-options = Options
heading-general-options = General options
heading-examples = Examples:
option-help = Print help
option-version = Print version
usage-options = OPTIONS
usage-command = COMMAND

# help/errors.rs: errors in the arguments. In English clap has its own words.
usage-error = Error: { $what }
usage-error-meant = Error: { $what }. Did you mean `{ $meant }`?
usage-more = More: lafet --help or lafet COMMAND --help
needs-value = `{ $arg }` needs a value
value-not-known = invalid value `{ $value }` for `{ $arg }`; possible: { $known }
value-wrong = invalid value `{ $value }` for `{ $arg }`{ $why }
argument-unknown = unknown argument `{ $arg }`
command-unknown = unknown command `{ $name }`
arguments-conflict = `{ $arg }` cannot be used with `{ $other }`
arguments-missing = arguments are missing: { $arg }
command-missing = the command is missing
value-too-many = unexpected value `{ $value }` for `{ $arg }`
value-count = wrong number of values for `{ $arg }`
equals-missing = `{ $arg }` needs = behind it
argument-not-utf8 = the argument is not UTF-8
reason-range = : allowed: { $range }
reason-integer = : expected a whole number within the limits
reason-number = : expected a number
map-no-server = { $file } has no such [[modbus_server]].

# installed/
install-head = { $file }, as user { $user }
install-as-root = Examine it as root: sudo lafet doctor --install
install-user-missing = There is no user { $user } on this machine.
install-user-missing-remedy = adduser --system --group --no-create-home --home /var/lib/lafet { $user }; or name the user who runs the hub with --user
install-config-missing = There is no configuration { $file }.
install-config-missing-remedy = lafet serve --example > { $file }, then enter the monitors of the site in it.
install-config-denied = { $user } may not read { $file }.
install-config-denied-remedy = chgrp { $user } { $file } && chmod 0640 { $file }, and the folders above it must let that user through.
install-config-writable = Users other than root and the hub’s can change { $file }.
install-config-wrong-remedy = Correct the file. lafet serve --config { $file } --check reports all that is left.
install-state = { $folder } belongs to the hub alone, and this version can use it.
install-state-new = { $folder } does not exist yet; the first start makes it.
install-state-denied = { $folder } does not exist, and { $user } may not make it.
install-state-owner = { $path } does not belong to { $user }, so the hub cannot write it.
install-state-open = Other users can look into { $folder }, which has the users and the audit log.
install-state-newer-remedy = Install the newer version again.
install-group = { $user } is not in the group { $group }, which may use serial ports.
install-group-remedy = usermod -aG { $group } { $user }, then start the hub again.
install-ports = Serial ports in the configuration: { $count }; all are there, and free for the hub.
install-ports-remedy = lafet ports lists the ports. A name below /dev/serial/by-id or /dev/lafet stays the same after a restart.
install-port-denied = { $user } may not open { $port }, which is for the group { $group }.
install-port-busy = { $port } is in use by { $program } (process { $pid }).
install-port-busy-remedy = Stop that program. ModemManager takes new ports by itself: systemctl disable --now ModemManager
install-running = A hub runs; it has { $listen }.
install-listen-taken = Another program listens on { $listen }.
install-listen-taken-remedy = Find it with ss -ltnp and stop it, or set another address: listen in [server].
install-listen-denied = This user may not listen on { $listen }.
install-listen-denied-remedy = Under the unit the hub may: CAP_NET_BIND_SERVICE. Otherwise choose a port above 1023.
install-listen-wrong-remedy = Set an address of this machine: listen in [server].
install-unit-active = { $unit } runs, and will at the next start of the machine.
install-unit-missing = systemd does not know { $unit }: nothing starts the hub after a power cut.
install-unit-disabled = { $unit } is not enabled: nothing starts the hub after a power cut.
install-unit-failed = { $unit } has failed.
install-unit-stopped = { $unit } does not run.
install-unit-masked = { $unit } is masked: it cannot be started, and nothing starts the hub after a power cut.
install-program-old = { $unit } runs the program from before an upgrade; the new one is used from the next start on.
install-recordings-denied = { $user } may not write { $folder }, where recordings are to be.
install-clock = The clock of this machine is not synchronized: times in the audit log and the history are only as good as it is.
install-clock-remedy = timedatectl set-ntp true, with a time server that this machine can reach.

# word.rs
no-random-bytes = the system gives no random bytes

# version.rs
version-commit = commit
version-target = built for
version-profile = profile
version-features = with
version-allocator = allocator
version-none = nothing more
version-system = that of the system
version-unknown = unknown

site-answered = { $question } — { $answer } (from the file)
site-hint-yes-no = [y yes, n no, s skip, q end the test]
site-hint-degrees = [degrees, s skip, q end the test]
site-hint-pressure = [0.1 atm, s skip, q end the test]
site-file-too-long = { $shown } is longer than { $most } MiB: it is no plan, answer, key or record of a site
site-hint-name = [{ $names }, n none, s skip, q end the test]
site-bad-url = { $url } is no address of a hub: write http://HOST:8480 or https://HOST:8480
site-bad-ca = { $file } has no usable certificate: { $error }
site-not-done = the monitor has not answered that all of it is done
site-lost = { $url } is not reached: { $error }. Does the hub run, and is the address right?
site-counts = pass { $passed }, FAIL { $failed }, not tried { $not_tried }
site-signed = signed with { $public }
site-bad-key = { $shown } holds no key: 64 hexadecimal digits, as of: openssl rand -hex 32
site-key-alone = --key signs a record: add --record or --records.
site-no-signature = { $shown } holds no signature: ed25519, public key, signature
site-verified = { $shown } is as it was signed with { $public }
site-not-verified = { $shown } IS NOT AS IT WAS SIGNED, or not with the key that is wanted; the signature names { $public }
site-too-many = { $shown } has more than { $most } records. Move older ones to another folder.
site-no-calendar = The plan has no calendar: add for example [calendar] with read_days = 1, dry_days = 7 and outlet_days = 365.
site-every = every { $days } d
site-due = due { $date }
site-due-now = DUE
site-never = never
