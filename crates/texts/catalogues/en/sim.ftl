## What the simulator says: exercises and their pictures, throws.

verdict-passed = PASSED: { $held } of { $all } hold
fire-news = fire { $fire } { $what }
link-news = { $monitor }: { $interface } { $what }
address-taken = { $monitor } has this address already
no-toml = no TOML: { $message }
missing = is missing: { $what }
numbers = { $count } numbers: [1, 2.5]
interface-lost = { $interface } lost
interface-answers-lost = { $interface }: answers lost
request-by-radio = { $request } (radio)
outside-law = { $what } { $value } { $unit }: the law holds from { $least } to { $most } { $unit }
unit-degree = °

too-late = too late
never-came = the time for it never came

fire-unknown = `{ $condition }`: no fire is called `{ $name }`; known: { $known }
monitor-unknown = `{ $condition }`: no monitor is called `{ $name }`; known: { $known }
condition-missing = a condition is missing
condition-not-understood = the condition is not understood: { $error }

needs-monitor = at least one [[monitor]] is needed
needs-scenario = [scenario] is missing
monitors-at-most = at most { $most } monitors
fires-at-most = at most { $most } fires
drains-between = from 10 s to 1 h
only-tank = only a tank
fire-at-or-on = at = [x, y] or on = "a tank"
name-without-blanks = a name without blanks
name-exists = `{ $name }` exists already
set-refused = `{ $line }` is answered with { $status }
no-request = `{ $request }` is no request: { $error }

a-number = a number, { $what }
a-whole-number = a whole number, { $what }
empty-list = an empty list has no effect: leave it out
true-or-false = true or false
text-in-quotes = text in quotes
text-or-texts = text, or a list of texts
a-table = a table: {"{"} … {"}"}
tables = tables: { $form }
word-unknown = `{ $word }` is not known here; allowed: { $known }
no-time = `{ $text }` is no time: write 500ms, 20s or 1.5min

fault-injected = { $name }: fault { $fault }
fault-repaired = { $name }: { $fault } repaired
all-repaired = { $name }: all repaired
wind-from = wind from { $from }°, { $speed } m/s
air-temperature = air { $celsius } °C
fire-ignited = { $name } is lit
link-back = is back
link-lost = is lost
link-loses-answers = loses the answers
power-back = { $name }: power back
power-cut = { $name }: power cut
button-pressed = { $name }: { $post } { $button } pressed
button-released = { $name }: { $post } { $button } released
supply-at = { $name }: pressure at { $percent } %
fire-burns = burns
fire-hit = is reached by water
fire-out = is out
fire-reignited = flares up again
interface-radio = radio link
interface-wired = wired link

two-places = two places at least

controller-looks-again = controller: nothing found, looks once more
controller-nothing-burns = controller: nothing burns any more

no-power = no power
pump-at = { $name }: pump at { $percent } %

no-answer = no answer

needs-expect = at least one [[expect]]: a scenario that expects nothing proves nothing
which-monitor = which monitor? One of: { $known }
needs-trigger = at, when or after is needed
needs-action = nothing happens here; give one of: inject, clear, wind, gusts, wind_from, temperature, ignite, radio, external, power, press, release, supply
a-button = a button: { $known }
needs-expectation = one of that, never, always is needed
no-effect-without = has no effect without { $what }
no-effect-beside = has no effect beside { $what }
after-the-end = this never comes: the scenario ends at { $end }
waits-for-itself = waits for itself: it never comes
nothing-to-undo = nothing to undo: no event of this scenario does the opposite to { $monitor }
supply-unused = no monitor has this supply
no-unit-there = has no effect: what it breaks is no remote unit of { $monitor }
monitor-lacks = has no effect: { $monitor } has no { $subsystem }
never-answered = has no effect: a request that is repeated until it is answered is never without an answer

heading-time = Time
heading-events = What happened
heading-monitors = Monitors
heading-fires = Fires
heading-expectations = Expectations
verdict-failed = FAILED: { $failed } of { $all } do not hold
monitor-figures = {" "} { $monitor }: water { $litres } l in { $seconds } s, first { $first }, up to { $most_atm } atm; turned { $turned }°, raised and lowered { $raised }°; requests sent/agreed/refused/unanswered { $counts }; warnings { $warnings }, restarts { $restarts }
fire-never-burned = {" "} { $fire }: never burned
fire-figures = {" "} { $fire }: burned from { $lit }, reached by water { $hit }, out { $out }; flared up again { $reignited }×, up to { $size_m } m across

jet-begins = the jet begins
jet-ends = the jet ends
water-in-folded-barrel = WATER IN THE FOLDED BARREL
program-starts = the program starts
request-without-answer = { $monitor }: { $request } → no answer
turn-never-came = its turn never came

picture-passed = ✓ passed: { $all } of { $all }
picture-failed = ✗ failed: { $failed } of { $all }
picture-run = { $duration } min, seed { $seed }

plan-never-burned = never burned
plan-out = out
plan-burns = BURNS
unit-m = m
north = N
indoors = indoors
calm = calm
unit-mps = m/s
gusts = gusts { $most }

heading-plan = On the plan
all-answered-as-expected = all { $all } requests are answered as expected
monitor-water = { $monitor }: { $litres } l in { $seconds } s, water from { $first }
monitor-no-water = { $monitor }: no water
legend-depth = water fallen, l/m²
legend-dotted = dotted: limits of the azimuth, reach of the jet in still air
legend-circle = circle of a fire: filled while it burns, pale when it is out, dashed: its greatest extent

azimuth = azimuth
chart-elevation = elevation
pressure = pressure
unit-atm = atm
flow = flow
unit-lps = l/s
heat = heat of fires
unit-mw = MW
chart-nozzle = nozzle
unit-mm = mm
deployer = deployer
vertical-drive = vertical drive
time-axis = min:s
bar-cause = fault
log-flag = { $subsystem } { $flag }: { $meaning }
bar-flag = reported

unit-mpa = MPa
outlet = outlet
nozzle-position = nozzle
smooth-bore-has-no-spray = a smooth bore has no spray: leave out the position of the nozzle
elevation = elevation
height = height
wind = wind
wind-direction = wind direction
note-pressure = No published row has this pressure and outlet: the band is extrapolated.
note-elevation = Rows are known for elevations of 20–45° only: the band is extrapolated.
note-monitor = No row states the middle or the top of a monitor's jet: their bands are those of smooth bores, widened by that of the greatest reach.
note-spray = No row of a spray is known: its band is wider by a share that is ours.
note-wind = No row of a jet in wind is known: the band is wider by a third of what the wind changes (ours).

# What is wrong with a fire, a glare or a wall on a line: az=30,range=25.
given-unnamed = `{ $field }`: expected name=value
given-unknown = `{ $name }`: known are { $known }
given-no-number = `{ $field }`: `{ $value }` is not a number
given-too-little = `{ $field }`: least is { $least }
given-outside = `{ $name }={ $value }`: { $least } to { $most }
given-direction = `{ $field }`: -360 to 360 degrees
given-class = `{ $field }`: solid or hydrocarbon
given-needed = { $name }= is needed
given-no-place = az= and range= are needed

# What is wrong with a condition of a scenario.
word-none-of = `{ $word }` is none of { $known }{ $meant }
flag-unknown = `{ $name }` is no flag of { $subsystem }{ $meant }
or-meant = ; did you mean `{ $name }`?
flag-has-no-states = `{ $flag }` of { $subsystem } has no states: leave out `={ $state }`
condition-form = `{ $condition }`: expected PATH OP VALUE
none-is-alone = `none` has to be alone, after = or !=
path-leads-nowhere = `{ $path }` leads nowhere here
condition-number = `{ $wanted }`: a number is expected here
condition-word = `{ $word }` is a word: only = and != fit
condition-flags = flags: only has, lacks, = and != fit
condition-words = `{ $path }`: too many words
fire-has = `{ $what }`: heat, size, density, covered, heated, burning, out, unlit

# What is expected on a line of a test scenario, and what came.
failure-expected = { $file }:{ $line }: expected { $expected }
failure-came = came { $came }
line-first = a setting or `case` before the first case
line-answer = `<` right after `>`
line-needs-answer = `<` with the answer (or `!` to prepare)
line-early-end = `never` or `always` before its `end`
line-nothing-to-end = nothing to end
line-checks = a case that checks something
line-nothing = nothing
line-number = a number
line-two-numbers = two numbers
line-profile = a profile's name
line-address = an address
line-milliseconds = milliseconds
line-drive = a drive
line-one-of = one of: { $known }
line-source = external or radio
line-until = `until CONDITION within TIME`
line-button = a post and a button: `press buttons left`
line-fault = the name of a fault
line-power = power cycle, or power cut N old|new|mixed|random|unstable: in the word after N others
line-crash = `crash` alone
line-damage = the number of a stored value
line-word = a line of a case ({ $known })
line-hex = hex, not `{ $word }`
line-time = a time: 500ms or 2.5s
line-hour = at most an hour
run-stored-value = a stored value { $key }
run-nothing-stored = nothing is stored there
run-no-answer = no further answer
run-answer-after = `{ $wanted }` after `{ $asked }`
run-none-after = no further answer after `{ $asked }`
run-taken = `{ $asked }` to be taken
run-within = { $condition } within { $ms } ms
