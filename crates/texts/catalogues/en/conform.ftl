## What the conformance tester says: what an item requires, what was found, the report.

# bench.rs
records-carried = the connection carries bare records
interrupted = interrupted
one-answer = §1/10: one answer to a frame
another-frame-came = another frame came after it
answer-frame = §1/10: an answer frame
nothing-within = nothing in { $ms } ms
frame-without-errors = §L/2: a frame without errors
addresses-swapped = §L/6: dst and src of the request, swapped
whole-records = §2: whole records
status-known = §2/5: a status from 0 to 18
one-answer-record = one answer record to this request
answer-without-data = an answer without data
locked-out = the monitor is locked out
word-of-flags = §3.3: a word of flags
bytes-of-drive = §3.3: the 8 bytes of a drive
subsystem-missing = no { $name }
no-such-subsystem = no such subsystem
within = { $what }, within { $seconds } s
not-so = it is not so
flags-become = { $name }: flags { $set } set, { $clear } clear
id-and-values = §3.4: the id and int32 values
ok-once-answered = §3.4/2: Ok once the unit has answered
parameter-missing = the monitor has no parameter { $name }: the list is ours
taken-once-free = §3.5/7: taken once the unit is free

# run.rs
as-before-the-test = everything is as before the test
link-failed = the link: { $error }
not-moved = not tried: an answer breaks the protocol, so the monitor cannot be seen to be at rest and is not moved
expected-and-found = expected { $expected }; found { $found }

# safety.rs
at-work = the monitor is at work (something moves): it is not tested now
program-or-search-runs = a program or a search runs: the monitor is not tested now
locked-out-by-others = the monitor is locked out, for a reason unknown here. Only --read-only is possible
valve-not-closed = a valve is not closed: close it first
moves-unasked = { $name } moves or opens although nothing has asked it to: Stop All was sent
stop-all-stops = §3.2/1: Stop All stops everything
still-moves = something still moves

# checks/fold.rs
one-state-of-deployer = one state of Deployer at most
position-asked-for = the position asked for
stays-wrapped = it stays wrapped
ok-or-accepted-from-all = Ok or Accepted from all
nothing-is-done = nothing is done
deploying-then-deployed = Deploying, then Deployed
deploying-until-deployed = Deploying until Deployed
goes-on-deploying = it goes on deploying
between-the-states = neither of the four states
no-place-in-between = Deployer knows no place in between
under-way = under way
stops = it stops
stays-deployed = it stays deployed
deployer-draws-too-little = Deployer draws too little
not-wrapped = not wrapped

# checks/limits.rs
no-such-drive = no drive of this kind
taken-once-unit-free = Ok or Accepted, once its unit is free
busy-for-moment-only = Busy for a moment only
limits-stay-on = limits stay on
nothing-changes = nothing changes
previous-limits-are-reported = the previous limits are reported
same-limits-again = the same limits again
old-limits-until-on = the old limits until On
limit-taken-is-in-force = the limit taken is in force
old-limits = the old limits
only-present-position = InvalidValue but for the present position
too-little-room = too little room
runs-on-until-stopped = it runs on until stopped

# checks/link.rs
an-answer-to = an answer: { $what }
no-answer-to = no answer: { $what }
good-frame-after = to a good frame after it
wrong-crc = a wrong CRC
datagram-is-one-frame = a datagram is one frame
frame-after-noise = a frame after noise
no-early-answer = no answer before the frame has ended
frame-sent-byte-by-byte = a frame sent byte by byte
two-frames-at-once = two frames at once: two answers in their order
db-00-no-escape = DB 00 is no escape
new-frame-after-three-bytes = C0 after three bytes starts a new frame
probe-swapped = the probe with dst and src swapped
frame-for-another = a frame for another address
frame-from-own-address = a frame with the own address as src
frame-too-long = a frame over the payload limit
another-monitor = another monitor is on the line
answers-in-its-name = what answers a probe in its name
probes-limited = 255 probes answered at once, then one every 512 ms
request-after-probes = a request after the probes
frame-not-known = it does not know this frame: it is ours
answer-with-crc32c = the answer with CRC-32C too
wrong-crc32c = a wrong CRC-32C
answered-at-first-try = each frame is answered, once, at the first try (is the line noisy?)
no-second-answer = no second answer
same-frame-again = the same frame again
one-connection-only = one connection only on this medium
answer-to-who-asked = the answer goes to who asked
answer-on-second-connection = an answer on the second connection
on-first-connection = on the first connection
link-frames-carried = the connection carries link frames
answer-to-each-record = an answer to each record

# checks/memory.rs
parameters-not-saved = not all parameters can be saved: nothing is erased
nothing-is-erased = nothing is erased
copy-is-written-back = the copy is written back
memory-was-not-erased = the memory was not erased
nothing-to-ask = there was nothing to ask
ok-once-stored = Ok once it is stored

# checks/motion.rs
speed-while-moves = a speed while it moves
arrives-at = at { $at } ± { $tolerance }, at rest
new-limits = the new limits
stays-at-rest = it stays at rest
buffer-holds-all-answers = the buffer holds all answers
move-after-no-room = Move after NoRoom is not executed
two-answers = two answers
wrong-data-from-addressee = WrongData from the addressee
one-wrong-data = one WrongData
drive-draws-too-little = the drive draws too little
overload-over-max-current = AmperageOverload over MaxCurrent
direction-refused = that direction is refused
flag-after-stop = the flag for 3 s after the stop

# checks/params.rs
own-parameters-unknown = none of our parameters is known
read-back-at-once = read back at once
read-back-later = and later
value-as-set = the value as set
no-stored-programs = no stored programs
all-values-of-array = all values of an array
accepted-with-id = Ok or Accepted with the id
own-parameters-missing = our parameters are not known
cached-then-accepted = Cached, then Accepted
units-new-value = the unit's new value
no-remote-drive = no remote drive
new-value-is-read = the new value is read
ok-once-value-stored = Ok once the value is stored
accepted-then-ok = Accepted, then Ok
accepted-for-new-value = Accepted for a new value
accepted-while-turning = Accepted, not yet stored, while a drive turns
ok-after-motion = Ok after the motion
no-bad-power-before = no BadPower before
box-temperature = the box is too warm or too cold

# checks/programs.rs
within-sector = within the sector
closed-valve-stays-closed = the closed valve stays closed
no-program-runs = no program runs
whole-sector = the whole width and more than one line of the sector
raised-by-correction = the barrel 5° over the line of sight
aimed-at-centre = aimed at the centre
no-ballistics-fault = no fault of the ballistics when it is off
narrowest-jet = the narrowest jet
paused-for-3-s = paused for 3 s
where-move-sent = where Move sent it
on-around-point-reached = on around the point reached
program-goes-on = the program goes on
inside-limits = inside the limits
outside-limits-stays = OutsideLimits stays until the next start
no-sector-is-outside = no sector is outside
new-sector = the new sector
point-after-point-then-end = point after point, then the end
starts-over = it starts over
trajectory-in-use = Trajectory7 is not empty
wrong-data-or-invalid-value = WrongData or InvalidValue

# checks/reads.rs
answers-do-not-fit = the buffer does not hold the answers
bytes-from = { $size } bytes from { $from }
ok-with-structures = Ok with the structure of each
same-flags-as-subsystem-alone = the same flags as the subsystem alone
unused-flags-are-0 = flags without a meaning are 0
supply-voltage-in-v = a supply voltage in V
not-open-and-closed = not open and closed at once
temperatures-and-humidity = temperatures in 0.1 °C and humidity in %
one-state-at-most = one state at most
no-button-is-pressed = no button is pressed
speed-0-at-rest = speed 0 at rest
no-conn-lost-after-request = no ConnLost after a control request
no-conn-lost-early = no ConnLost before its time
conn-lost-after-silence = ConnLost after 3 s without control
conn-lost-without-control = ConnLost, as there was no control
reads-are-no-control = reads do not count as control
values-of-parameter = as many values as the parameter has
id-comes-back = the id comes back
ok-once-fetched = Ok once fetched
parameters-are-unset = parameters are unset
every-parameter = every parameter of the table
values-in-range = values within the table's range
limits-in-order = int32 min and max, min not above max
limits-of-parameters = the limits set by the parameters
no-drive = no drive
every-drive-in-order = every drive, in chain order
size-of-crash-data = 80 or 48 bytes
words-of-fault-info = the words of GetParam General FaultInfo
size-of-hotbeds = FE 23 and n × 20 bytes, n = 0…4
hotbeds-brightest-first = at most 4 hotbeds, brightest first
data-of-hotbeds = the data of GetParam Hotbeds

# checks/records.rs
answers-to-this-request = answers to this request
ids-of-table = ids of the table of §1
general-answers = General answers
general-answers-last = answers in chain order, General last
each-answers-to-all = each subsystem that answers alone answers to All, once
general-alone = General alone
answer-to-each-request = an answer to each request, in their order, in one frame
all-answers-or-no-room = all answers, or NoRoom
two-no-rooms = NoRoom of the subsystem that has none, then one of General
nothing-after-no-room = nothing after NoRoom
answers-then-no-room = answers, and then NoRoom
bytes-of-status = D4 C2 00 0A and 10 bytes
bytes-of-crash-data = 06 C2 00 and the crash data
as-with-status-0 = as with status 0
cut-record-is-wrong-data = the whole record is answered, the cut one WrongData
own-request-id = its own request id
ok-from-all-stoppable = Ok or Accepted from every subsystem that can be stopped, in chain order

# checks/search.rs
found-when-hotbeds = Found when there are hotbeds
not-canceled = not Canceled
search-goes-on = the search goes on
valve-stays = the valve stays
next-start-clears = the next start clears it
ends-at-once = it ends at once
justified-or-fault = Justified, or DeviceFault where there is no target

# checks/service.rs
ok-from-all = Ok or Accepted from every subsystem, in chain order
not-locked-out = not locked out
set-param-works = SetParam works
get-param-works = GetParam works
ok-from-general = Ok from General once it is stored
accepted-until-stored = Accepted until the release is stored
does-not-restart = it does not restart
answers-after-restart = it answers again after the restart
line-too-slow = the line is too slow to see it restart
restarting-and-readable = Restarting, and reads are answered
accepted-is-kept = what was accepted is kept
nothing-moves-after-start = nothing moves after the start
sensors-show-deployed = the sensors show that it is deployed

# checks/timed.rs
moves-while-repeated = it moves on while Move is repeated
set-param-and-move-taken = SetParam and Move are taken
moves-while-renewed = it moves on while MoveHold is renewed
renewal-starts-nothing = a renewal starts nothing

# checks/update.rs
no-update-over-link = the software of this monitor is not updated over its link
update-under-way = an update is under way: it is left alone
has-update = the software of this monitor is updated over its link
report-of-24-bytes = a report of 24 bytes from General
report-possible = a report of a phase from 0 to 4, slot 1 or 2, no more bytes than there are, and nothing in phase 0
same-software = the same software, and no update
software-parameters = SoftwareVersion, SoftwareSlot and SoftwareHash of General say what the report says
software-not-set = AccessDenied: what is running is not set
nothing-carried-out = nothing is carried out: the report is as before
wrong-data-without-report = WrongData without a report
orders-accepted = in standby and locked out, an order is accepted
order-waits-no-more = the order does not wait any more
not-started = a header ({ $what }) starts nothing: reason { $reasons }
not-carried-out = not carried out: reason { $reason }
header-no-image = no image
header-format = another format
header-field = a field that cannot be
header-revokes = it revokes its own key
header-board = another board
header-forged = not signed by its maker
header-large = larger than a slot

# checks/water.rs
valve-stays-closed = the valve stays closed
valve-stays-open = the valve stays open
stop-all-stops-valve = Stop All stops the valve
open-valve-stays-open = the open valve stays open

# report/: the report, as text and as a page.
pass = pass
fail = fail
differs = differs
not-applicable = n/a
expected = expected
found = found
summary = --{ $level }: { $pass } passed, { $fail } failed, { $differs } differ from a ruling of ours, { $not } not applicable; { $frames } frames ({ $repeats } repeated) in { $s } s
broken-off = Broken off
not-restored = NOT RESTORED
title = Conformance of a fire monitor
nothing-failed = Nothing failed
something-failed = Failed
subsystems = Subsystems
test = Test
statement = Statement
result = Result
observed = observed
ours = ours
bytes = Bytes
not-testable = What cannot be tested over the wire
