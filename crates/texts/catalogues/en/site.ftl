## What the zone controller says: refusals, why a zone is not released, troubles, its configuration.

refusal-lockout = Lockout is on. Release it first.
refusal-off = The zone is switched off. Set another mode first.
refusal-abort-pressed = An abort contact is pressed. Release it first.
refusal-just-refused = A Stop, Close, abort or lockout came at the same time. Try again after 2 s.
refusal-released = The zone is released. End the release first.
refusal-too-late = It is too late: the zone is released already. Abort ends it.
refusal-no-hold = The zone has no hold.
refusal-unknown = The name is not configured.
refusal-range = The value is out of range: a test lasts 1 to 3600 s, another mode 1 to 604800 s; a test of the outlet needs a test outlet.
refusal-still-pressed = A contact that says the opposite is still pressed.

not-released-lockout = lockout is on
not-released-abort-pressed = abort is pressed
not-released-stop-pressed = a stop contact is pressed
not-released-ended = it was ended; reset the zone
not-released-mode = the zone is not in automatic
not-released-votes = { $have } of { $need } votes
not-released-kinds = the votes are of too few kinds
not-released-failed = too many detectors have failed
not-released-stale = an alarm that was there at the start has no vote
not-released-coincidence = the votes have to coincide for longer
not-released-delay = the delay runs
not-released-held = the delay is held
not-released-no-monitor = no monitor can serve the zone
trouble-detector-fault = fault of a detector
trouble-detector-silent = a detector is silent
trouble-detector-dirty = a detector's window is dirty
trouble-detector-stuck = a detector's self-test does not end
trouble-path = a line is at fault
trouble-contact-stuck = a contact is stuck: a release contact that was pressed when it was first read, or a hold that is pressed since before the alarm or for too long
trouble-monitor-unreachable = a monitor does not answer
trouble-monitor-failure = a monitor has failed
trouble-monitor-idle = a monitor does not act on the order
trouble-not-closed = a valve is not reported closed
trouble-output-overdue = an output is not reported as commanded
trouble-pump-overdue = a pump is not reported as ordered
trouble-pump-failed = a pump gives no pressure
trouble-no-pressure = no pump gives pressure
trouble-no-monitor = no monitor can serve a released zone
trouble-few-jets = fewer monitors at work than the zone wants

out-of-range = { $key } = { $value } is out of range.
out-of-range-remedy = Write { $least } to { $most }.
not-configured = { $key } names `{ $name }`, which is not configured.
not-configured-remedy = Correct the name or add it.
named-twice = { $key } names `{ $name }` twice.
named-twice-remedy = Name it once.
id-length = The id `{ $id }` is empty, too long or of dots alone.
id-length-remedy = Write 1 to { $most } characters, not dots alone.
id-twice = The id is used twice.
id-twice-remedy = Give each its own id.
too-many = { $count } are too many.
too-many-remedy = { $most } at most; divide the site.
detector-without-zone = It has no zone, so its alarm would show nowhere.
detector-without-zone-remedy = Name its zone in `zones`.
starts-in-test = A zone cannot start in a test.
starts-in-test-remedy = Write automatic, manual or off.
votes-impossible = votes = { $votes } needs no vote, or more than there are.
votes-impossible-remedy = Write, for example, 2oo3.
votes-not-of-detectors = votes = { $votes }, but the zone has { $count } detectors.
votes-not-of-detectors-remedy = Write …oo{ $count }, or correct `zones` of the detectors.
one-vote-releases = One detector would release water by itself.
one-vote-releases-remedy = Require two votes, or write one_detector_releases = true.
kinds-impossible = kinds = { $needed } can never be met: { $votes }, { $kinds } kinds.
kinds-impossible-remedy = Write 1 to the number of votes and of kinds in the zone.
reduced-not-fitting = when_failed: { $votes } does not fit { $failed } failed of { $of }.
reduced-not-fitting-remedy = Write …oo{ $left } with at least { $kinds } votes, or "alarm".
reduced-to-one = when_failed: with { $failed } failed, one detector would release water.
reduced-to-one-remedy = Write "alarm", or one_detector_releases = true.
no-monitor = No monitor serves it.
no-monitor-remedy = Name its monitors in `monitors`.
jets-impossible = jets = { $jets }, but { $monitors } monitors serve it.
jets-impossible-remedy = Write 1 to the number of its monitors.
valve-used-twice = The valve `{ $output }` is used more than once.
valve-used-twice-remedy = Give each zone and test outlet its own valve.
contact-of-whole-site = Lockout and pressure are for the whole site.
contact-of-whole-site-remedy = Remove `zones`.
station-without-zones = A release station without zones would start the whole site.
station-without-zones-remedy = Name its zones.
valve-unused = No zone uses this valve.
valve-unused-remedy = Name it in `valve` or `test_outlet` of a zone.
all-standby = All pumps are on standby, so none would ever start.
all-standby-remedy = Remove `standby` from one of them.

stored-version = The stored state has version { $found }, not { $wanted }.
stored-version-remedy = Use the program that wrote it, or accept its loss and set masks and modes again.
