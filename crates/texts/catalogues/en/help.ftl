## Help of the command line: a text for each command and argument. `param-get` is `lafet param get`, and
## `param-get-arg-name` its argument `name`; `arg-json` is an option of every command.

lafet =
    Control, simulate and inspect robotic fire monitors.

    Exit codes: 0 done; 1 refused by the monitor, or not completed; 2 wrong usage; 3 no answer; 4 what was started may still move or flow; 130 interrupted, and at rest.
arg-connect = The monitor: tcp://HOST:PORT?addr=1, udp://…, serial:///dev/ttyUSB0?baud=19200, or sim: for a simulated one (sim:?profile=full&seed=7&fire=az=30,range=25). Also in LAFET_CONNECT
arg-json = Print JSON, one object per line
arg-lang = Language: en or ru; otherwise LC_ALL, LC_MESSAGES or LANG decides
arg-timeout = How long to wait for each answer, seconds (default 1); reads are tried three times
arg-insist = Send even if others are heard on the line, or bytes that are no frames: it may collide with a Stop of theirs

sim = Simulate a monitor that others can connect to
sim-arg-listen = Where to listen: tcp://HOST:PORT, udp://HOST:PORT or pty; prefix radio+ for the radio interface; port 0 takes a free one. May be repeated (default tcp://127.0.0.1:10485)
sim-arg-firmware = Run this monitor program in QEMU instead of our own (an ELF file for the board lm3s6965evb, see firmware/; with --boot a signed image); listens on one TCP address
sim-arg-boot = Run this bootloader (an ELF file for the board mps2, see firmware/) in front of the program, whose software can then be updated over the link; --firmware is the image that a new flash has in slot A. An existing --flash is left as it is
sim-arg-on = Where the monitor's program runs
sim-arg-profile = Configuration of the monitor: full, remote, mini, ex or limit-switch (default full)
sim-arg-addr = Address of the monitor, 1 to 127 (default 1)
sim-arg-seed = Seed of everything random (default 7, or the scenario's)
sim-arg-speed = Simulated seconds per second of real time (default 1)
sim-arg-fire = A fire: az=DEGREES,range=METRES, and optionally size=METRES, growth=M/S, reignites=1; left is positive; lit=0 is an object that other fires can ignite. May be repeated; without it nothing burns
sim-arg-fault = Break something from the start, such as horizontal-lag or pump-off (docs/faults.md). May be repeated
sim-arg-wind = Mean wind 10 m above ground: metres per second forward (as the barrel looks at 0°) and to the left; -5,0 is a head wind (default 0,0)
sim-arg-gusts = Gusts: standard deviation of the wind's speed over its mean, 0 to 0.5; 0.15 is open country, 0.3 among buildings; none without --wind (default 0)
sim-arg-glare = The sun or a hot machine, which the detector takes for a fire: az=DEGREES,el=DEGREES,size=DEGREES,brightness=N; a fire of 1.5 m at 25 m has 1400. May be repeated
sim-arg-wall = A wall that hides fires from the detector, not from the water: from=DEGREES,to=DEGREES,range=METRES,height=METRES. May be repeated
sim-arg-radio = Put radio modems between the radio+ listeners and the monitor, all on one half-duplex channel: rate=BITS/S,latency=MS,loss=SHARE,errors=SHARE (of bits); defaults rate=9600,latency=40,loss=0,errors=0. Without such a listener: radio+tcp://127.0.0.1:10486
sim-arg-flash = Keep the monitor's memory (parameters, lockout) in this file; with --board its software as well, in FILE.software
sim-arg-board = Let the software be updated over the link (`lafet update`): the name of the board that images are for
sim-arg-update-key = A public key that images are signed with: 0=key0.pub, as `lafet image public` writes it; 0 to 14, may be repeated
sim-arg-bad-trial = What becomes of an image on trial: dead-link (it answers nothing) or hangs; without it, it works
sim-arg-site = Serve all monitors of this scenario (a file, or the name of one that comes with lafet), with its fires and events, where it specifies; --listen puts all of them on one bus elsewhere

sim-run = Run a scenario in virtual time and report the result
sim-run-arg-file = A scenario file, or the name of one that comes with lafet (see --list)
sim-run-arg-seed = Seed of everything random (without it: the scenario's)
sim-run-arg-report = Form of the report: text or json (default text; --json is the same as json)
sim-run-arg-svg = Write a picture into this file: plan view and time lines
sim-run-arg-trace = Write the state of all monitors every 100 ms to this file
sim-run-arg-list = List the scenarios that come with lafet
sim-run-arg-show = Print the text of the scenario: a template for your own

serve = Run the hub: monitors of a site in the browser and over an API
serve-arg-config = Configuration (default: hub.toml here, then /etc/lafet/hub.toml)
serve-arg-example = Print an example configuration
serve-arg-check = Only report errors in the configuration
serve-arg-port = Port to listen on, instead of the configured one; 0 takes a free one
serve-arg-no-browser = Do not open a browser
serve-arg-verify-audit = Check an exported audit log for changed or removed entries
serve-arg-accept-lost = Continue although state files are lost or changed: hub (users), audit
serve-arg-unit = Print the unit file for systemd

demo = Try everything in the browser on a simulated site, or watch a monitor in the terminal
demo-arg-port = Port of the console (default 8480, or a free one if it is taken; 0 takes a free one)
demo-arg-no-browser = Do not open a browser
demo-arg-terminal = Show the picture in the terminal instead of the browser; implied by the options below except --seed
demo-arg-seed = Seed of everything random (default 7)
demo-arg-speed = Simulated seconds per second of real time; 0 is as fast as possible (default 1)
demo-arg-plain = Print lines of a log instead of the picture
demo-arg-fire = A fire: az=DEGREES,range=METRES[,size=METRES]; left is positive. May be repeated
demo-arg-picture = Write the picture of one moment into this SVG file, and show nothing
demo-arg-picture-at = The moment of --picture, simulated seconds (default 60)
demo-arg-trace = Write what happens to this file; byte for byte the same for the same seed

ports = List the serial ports of this computer

scan = Find the devices on a bus or a network
scan-arg-hosts = Hosts of a network: 192.168.1.0/24, 192.168.1.10-40, an address or a name; without them the bus of -c is scanned
scan-arg-port = Ports of the hosts, separated by commas (default 10485,10486)
scan-arg-udp = Look for UDP ports instead of TCP
scan-arg-addresses = Addresses to probe: 1-127, or one (default 1-127)
scan-arg-wait = How long each probe may take, milliseconds (default 30, over a network 100)
scan-arg-tries = How many times a silent address is probed (default 2)
scan-arg-brief = Do not ask the monitors for their subsystems

doctor = What is wrong with a link (or the hub here), and what to do
doctor-arg-url = The link to examine; without it, that of -c
doctor-arg-listen = Seconds to listen before the first request (default 3)
doctor-arg-wait = How long an answer may take, milliseconds (default 150, over a network 500)
doctor-arg-requests = Requests sent to measure the loss (default 30)
doctor-arg-install = Examine the installation of the hub instead of a link: configuration, rights, state, ports, address, unit, clock
doctor-arg-config = With --install: the configuration (default hub.toml here, else /etc/lafet/hub.toml)
doctor-arg-user = With --install: the user who runs the hub (default lafet for root, else you)

conform = Test whether a monitor does what the protocol says
conform-arg-url = The monitor to test; without it, that of -c
conform-arg-list = Only list the tests of this level: item, name, level; no monitor is needed
conform-arg-read-only = Reads, Stop, and frames that are refused: nothing moves (default)
conform-arg-motion = Drives move a little, slowly and without water; parameters are changed and restored
conform-arg-full = Everything but the erasure: water, programs, searches, lockout, restart; about ten minutes on a real monitor
conform-arg-erase = Everything; the memory is erased and restored from a copy
conform-arg-strict = Differences from our own rulings, where the document is silent, count as failures too
conform-arg-fail-fast = End at the first failure
conform-arg-only = Only tests of this item (§3.1 includes §3.1/4), or the test of this name; may be repeated
conform-arg-quiet = Show what failed or does not apply, not what passed
conform-arg-html = Write the report as one HTML page
conform-arg-junit = Write the report as JUnit XML, for build servers
conform-arg-text = Write the report as text
conform-arg-board = The board that signed images for this monitor name: with it, headers that its maker has not signed are tried as well (nothing is ever updated)
conform-arg-speed = Clock speed of a simulated monitor, times real time (default 1, or speed= of sim:)

status = Show the state of the monitor and what its flags mean
status-arg-subsystem = The subsystem; all without it

watch = Show the state repeatedly
watch-arg-subsystem = The subsystem; all without it
watch-arg-interval = Seconds between polls (default 1)
watch-arg-count = End after this many polls

top = Show several monitors on one screen, live
top-arg-monitors = The monitors; without them, that of --connect
top-arg-interval = Seconds between polls of the state (default 0.5)
top-arg-page = First page: list, detail or link
top-arg-once = Print one picture as text and end: for scripts. With --json, one object per monitor
top-arg-size = Size of that picture (default 80x24)

shell = Run commands on one connection, typed or from a script
shell-arg-monitor = The monitor; without it, that of --connect
shell-arg-keep-going = Continue a script after a command fails; the exit code is that of the first failure
shell-arg-no-history = Do not save the history of what was typed

move = Move a drive, and follow it until it is at rest
move-arg-drive = Vertical, Horizontal, Nozzle or Deployer
move-arg-position = Arc-minutes (1200) or degrees (20deg, 12°30'), mm for the nozzle; up and left are positive
move-arg-no-wait = Return as soon as the request is accepted

jog = Move drives with the arrow keys while a key is held
jog-arg-lease = Seconds for which a drive continues after the last repetition of a key (default 0.3)
jog-arg-first = The same after the first press, until the keyboard starts to repeat; without it as --lease, or 0.8 where the terminal reports the release of a key

stop = Stop everything, or one subsystem
stop-arg-subsystem = The subsystem; all without it

open = Open a valve
open-arg-valve = Valve1 (water, the default) or Valve2 (foam)
open-arg-no-wait = Return as soon as the request is accepted

close = Close a valve
close-arg-valve = Valve1 (water, the default) or Valve2 (foam)
close-arg-no-wait = Return as soon as the request is accepted

deploy = Deploy the barrel into its working position
deploy-arg-no-wait = Return as soon as the request is accepted

wrap = Stow the barrel in its standby position
wrap-arg-no-wait = Return as soon as the request is accepted

seek = Search a sector for fire
seek-arg-from-az = Start of the sector, horizontally: degrees, or arc-minutes like 1800' (default -90)
seek-arg-to-az = End of the sector, horizontally (default 90)
seek-arg-from-el = Start of the sector, vertically (default -10)
seek-arg-to-el = End of the sector, vertically (default 10)
seek-arg-analyse = Measure each fire spot precisely in a second pass
seek-arg-no-wait = Return as soon as the request is accepted

hotbeds = Show the fire spots that the last search found

justify = Align the fire detector with the barrel
justify-arg-no-wait = Return as soon as the request is accepted

quench = Extinguish a sector, or run a stored program
quench-arg-program = A stored program, 0 to 7; its own centre and nozzle are used unless they are given
quench-arg-centre = Centre of the sector: horizontal,vertical (1800,-120 or 30deg,-2deg)
quench-arg-sector = Width,height of the sector (default 0,0)
quench-arg-step = Degrees between the lines of the scan; 0 aims at the centre (default 0)
quench-arg-nozzle = Position of the nozzle, mm; 60 is the narrowest (default 60)
quench-arg-distance = Distance to the fire, m; the elevation is corrected for it, 0 aims straight
quench-arg-corrections = Degrees to add to the elevation at 0, 0.1, 0.2 … atm, separated by commas
quench-arg-empty = Run the program even if it is empty: the barrel deploys and aims straight ahead
quench-arg-follow = Follow it until it ends; Ctrl-C stops it (the valves stay as they are)

trajectory = Extinguish along a path
trajectory-arg-point = A point of the path: horizontal,vertical,metres,tenths of a second to dwell; repeat it
trajectory-arg-stored = Stored trajectories, 0 to 7, separated by commas
trajectory-arg-ballistics = Correct the elevation for the fall of the jet
trajectory-arg-repeat = Start again after the last point
trajectory-arg-follow = Follow it until it ends; Ctrl-C stops it (the valves stay as they are)

program = Show, store, clear or run the programs and trajectories stored in the monitor

program-list = List the stored programs and trajectories

program-show = Show a program or trajectory
program-show-arg-number = Number, 0 to 7
program-show-arg-trajectory = The trajectory of this number, not the program

program-set = Store a program or trajectory
program-set-arg-number = Number, 0 to 7
program-set-arg-centre = Centre of the sector: horizontal,vertical (1800,-120 or 30deg,-2deg)
program-set-arg-sector = Width,height of the sector (default 0,0)
program-set-arg-step = Degrees between the lines of the scan; 0 aims at the centre (default 0)
program-set-arg-nozzle = Position of the nozzle, mm; 60 is the narrowest (default 60)
program-set-arg-distance = Distance to the fire, m; the elevation is corrected for it, 0 aims straight (default 0)
program-set-arg-point = Store a trajectory: one point as horizontal,vertical,metres,tenths of a second; repeat it

program-run = Extinguish by a program or trajectory
program-run-arg-number = Number, 0 to 7
program-run-arg-trajectory = The trajectory of this number, not the program
program-run-arg-ballistics = Correct the elevation for the fall of the jet
program-run-arg-repeat = Start again after the last point
program-run-arg-empty = Run it even if it is empty: the barrel deploys and aims straight ahead
program-run-arg-follow = Follow it until it ends; Ctrl-C stops it (the valves stay as they are)

program-clear = Clear a program or trajectory
program-clear-arg-number = Number, 0 to 7
program-clear-arg-trajectory = The trajectory of this number, not the program

coverage = Compute how many jets reach each square metre of a site
coverage-arg-file = The site: a hub.toml, or a file of monitors, obstacles, keep-outs, supply, winds
coverage-arg-svg = Write a picture into this file: the plan with the fewest jets in any wind
coverage-arg-grid = With --json: the jets of every cell too, in every wind

throw = Compute how far a jet throws, with its band of uncertainty
throw-arg-flow = Flow: l/s, or with a unit (20, 1200l/min)
throw-arg-outlet = Instead of the flow: diameter of the outlet, mm
throw-arg-pressure = Pressure at the nozzle: MPa, or with a unit (0.8, 8bar)
throw-arg-elevation = Elevation, degrees; FROM..TO for a table
throw-arg-step = Step of the table, degrees (default 5)
throw-arg-kind = Kind of the nozzle: monitor (default), with an adjustable nozzle, as its makers state the reach; smooth, a smooth bore behind a straight barrel
throw-arg-nozzle = Position of an adjustable nozzle, mm: 60 narrowest (default), 0 widest
throw-arg-wind = Wind 10 m above the ground, m/s (default 0)
throw-arg-wind-from = Where the wind comes from, degrees clockwise from the direction of the jet: 0 (default) is against it, 90 from its right, 180 from behind
throw-arg-height = Height of the nozzle above the ground on which the water lands, m (default 1.5)
plan = Import a site's drawing as tables of hub.toml
plan-show = Show layers of a drawing, and how large it would be in each unit
plan-show-arg-file = The drawing: DXF, GeoJSON, SVG, PNG or JPEG
plan-import = Print tanks and walls of a drawing for hub.toml, with places of monitors and detectors
plan-import-arg-file = The drawing: DXF, GeoJSON, SVG, PNG or JPEG
plan-import-arg-unit = Unit of the drawing, which is never guessed: mm, cm, dm, m, km, in, ft, us-ft, yd; wgs84: degrees (GeoJSON); points: none, the scale is that of --point or --distance
plan-import-arg-layer = Use a layer as tank, wall, monitor or detector; height in metres, without it that of the drawing
plan-import-arg-mark = Point at something, as on a photograph: a tank by its centre and a place on its rim, a wall by its line, a monitor or detector by its place
plan-import-arg-point = A place as drawn that is known on the site, metres from its zero; two or more give turn and place, and check the unit
plan-import-arg-geo = The same by latitude and longitude (WGS 84); needs --zero
plan-import-arg-distance = Two places as drawn and their known distance, which checks the unit
plan-import-arg-scale = Scale of a drawing on paper: 500 for 1:500 (default 1)
plan-import-arg-origin = Place as drawn that is the zero of the site (default 0,0)
plan-import-arg-north = Where north is on the drawing, degrees clockwise from its upper edge (default 0)
plan-import-arg-zero = Where the zero of the site is on the Earth (WGS 84)
plan-import-arg-ground = z of the ground as drawn: heights count from there
map = Print the register maps of the hub's servers
map-modbus = Print the register map of a Modbus server
map-modbus-arg-file = The hub.toml of the hub
map-modbus-arg-server = Name of the server (default: the first one)
map-modbus-arg-form = csv (default), with both languages and every bit; markdown; vectors, requests and answers as frames

site = Test an installation as a whole
site-test = Test an installation behind its hub against its plan, in safe steps
site-test-arg-plan = The plan: what was designed and surveyed (docs/site-test.md)
site-test-arg-hub = The hub
site-test-arg-token-file = A file with a token of the hub: observer for read and outlet, operator for dry
site-test-arg-ca = Certificate of the authority of the hub, PEM; else those of the system
site-test-arg-only = Steps: read, dry, outlet (default: read and dry)
site-test-arg-answers = Monitors that may turn without a question, TOML; nothing else is answered so
site-test-arg-record = Write the acceptance record into this file, JSON
site-test-arg-page = Write the record as a page for printing into this file, HTML
site-test-arg-records = Keep record and page in this folder, by the date
site-test-arg-key = Sign the record with the key in this file, into a file .sig beside it
site-test-arg-by = Who tests, for the record
site-calendar = Show when each step was last tried, and is due by the plan
site-calendar-arg-plan = The plan, with its calendar
site-calendar-arg-records = The folder of the records
site-verify = Check that a record is as it was signed
site-verify-arg-record = The record; its signature is the file .sig beside it
site-verify-arg-public = The public key that has to have signed it

calibrate = Fit the ballistics to the jet and fill the correction table
calibrate-arg-shot = A shot with the narrowest jet: pressure in atm, elevation in degrees, distance in metres to the middle of the wetted ground; repeat it, three or more at different pressures and angles
calibrate-arg-outlet = Instead of shots: use the simulated jet of this outlet, mm
calibrate-arg-distance = Distance for which the correction table is filled, m (default 30)
calibrate-arg-dry-run = Show the result and leave the monitor as it is; implied without -c

tune = Measure how a drive answers its motor, and set StopLag and MinSpeed
tune-arg-drive = The drive; without it Horizontal, Vertical and Nozzle in turn
tune-arg-dry-run = Measure and show, then set the parameters as they were

limits = Show the limits of motion, switch them, or set them from the barrel's position
limits-arg-what = The drive whose limits to show; or off, on, reject to switch them off, on, or to discard new ones
limits-arg-drive = The drive whose limits are switched; all without it

limits-teach = Drive the barrel to its limits and store them, or take the present position as one
limits-teach-arg-drive = The drive; without it Horizontal, Vertical and Nozzle in turn
limits-teach-arg-here = Do not prompt: take the present position as this limit (left, right, up, down, narrow, wide)

param = Read and set parameters

param-get = Read a parameter
param-get-arg-subsystem = The subsystem
param-get-arg-name = A name of the dictionary, any other name, or a number like 0x23fe

param-set = Set a parameter
param-set-arg-subsystem = The subsystem
param-set-arg-name = A name of the dictionary, any other name, or a number like 0x23fe
param-set-arg-values = The values

param-list = List parameters with their values, ranges and meanings
param-list-arg-subsystem = The subsystem; all without it

param-backup = Write all parameters to a file
param-backup-arg-file = The file, TOML; - writes to standard output
param-backup-arg-firmware = Version of the monitor's program, to note in the file: no request reports it
param-backup-arg-force = Replace an existing file

param-diff = Show what differs between a file and the monitor, or another file
param-diff-arg-file = A file written by `param backup`
param-diff-arg-other = Another such file; without it, the monitor

param-restore = Write what differs from a file to the monitor; continues after an interruption
param-restore-arg-file = A file written by `param backup`
param-restore-arg-dry-run = Show what would be written, and write nothing
param-restore-arg-force = Write even a file from a monitor with other subsystems or another address
param-restore-arg-except = Parameters to leave alone, separated by commas, like General.Address,Vertical.Speed

lockout = Lock the monitor out, or release it
lockout-arg-state = on: everything stops, valves close, every command is refused; off: the monitor works again

restart = Restart the monitor's program

crash = Show the record of the last hardware fault

update = Put new software into the monitor, over its link: it must be stowed and locked out
update-arg-images = The signed image: one that is linked for either slot, or two, one for each
update-arg-pace = How much of the line's time is used for it, 1 to 100 percent (default 20 on a serial line or a bus, where others wait meanwhile, else 100)
update-arg-watch = How long the new version has to answer and be as the old one was before it is confirmed, 5 to 120 seconds (default 20)
update-arg-state = Only show which version runs and how far an update is
update-arg-all = Update all monitors of this configuration of a hub (hub.toml), one after another in its order: each is locked out if it is not, and released again. The hub must not run; all are examined before anything is changed
update-arg-only = Of these, only the monitor with this id; may be repeated

image = Keys and signed images for `lafet update`

image-key = Make a key that signs images
image-key-arg-file = The new file: 32 random bytes, for its owner alone; an existing file is never written over

image-public = Print the public half of a key, as a board knows it
image-public-arg-id = The number of the key, 0 to 15
image-public-arg-file = The key
image-public-arg-out = A new file for it as well: for `image show --public` and `sim --update-key`

image-sign = Make a signed image of a program
image-sign-arg-program = The program, as bytes; it is filled up to a multiple of 8
image-sign-arg-image = The new file
image-sign-arg-key = The key that signs, by its number on the board: 0=key0
image-sign-arg-board = The board that it is for: 1 to 16 visible ASCII characters
image-sign-arg-version = Its version: one to four numbers, like 1.2.3; it has to be newer than what the monitor runs
image-sign-arg-slot = The slot that the program is linked for, a or b; without it, it runs in either
image-sign-arg-revokes = The number of a key that is no longer trusted once this image is confirmed; may be repeated
image-sign-arg-layouts = The layouts of stored parameters that it reads, the oldest and the newest, which it writes: 1-2

image-show = Show what an image is, and whether it is whole
image-show-arg-image = The image
image-show-arg-public = Check the signature with this public key: 0=key0.pub

send = Send any requests, written as text or in hexadecimal
send-arg-requests = Requests as text: each in quotes, or a single one without; or records in hexadecimal; - reads lines from standard input. Several are sent in one frame

decode = Decode captured bytes into text
decode-arg-input = Bytes in hexadecimal (link frames, or bare records), or a file; standard input without it
decode-arg-file = A file of captured bytes, raw or in hexadecimal, or a recording
decode-arg-raw = Take the input as raw bytes, even if it looks like hexadecimal
decode-arg-quiet = Show only the counters at the end

bus = Act as the controller of a bus with several monitors and consoles, or query one
bus-arg-urls = The line (default: the one of -c), and a second one if the consoles have their own: then everything is passed on between the two
bus-arg-listen = Let programs connect here and reach all monitors, in the controller's own turns: to them each monitor appears at tcp://ADDRESS?addr=N
bus-arg-addresses = Addresses in use, like 1-8,129; the controller never probes others (default all)
bus-arg-watch = Seconds of silence after which a monitor is checked for presence (default 5)
bus-arg-baud = Speed of the line behind a TCP or UDP link (default 19200; a serial URL gives its own)
bus-arg-latency = Delay that the links add to an answer, seconds: serial servers, radio modems (default 0, or 0.02 when a URL is not serial)
bus-arg-repeat-all = Repeat every unanswered request of a console, not only those that are safe to execute twice: a monitor whose answer was lost then executes the request twice
bus-arg-force = Start although there is a controller, or devices at another speed
bus-arg-duration = End after this many seconds; otherwise Ctrl-C ends it

bus-who = Show the addresses present on the bus

bus-log = Show the control requests that went over the bus
bus-log-arg-last = Show only this many of the last lines

record = Record the traffic of a line as MCAP or pcapng
record-arg-file = The recording: .mcap (Foxglove, Lichtblick) or .pcapng (Wireshark)
record-arg-force = Replace an existing file
record-arg-listen = Only listen, send nothing: for a bus that others use
record-arg-tap = Pass everything on between the monitor and the program that connects here
record-arg-interval = Seconds between requests for the state of all subsystems (default 0.1)
record-arg-duration = End after this many seconds; otherwise Ctrl-C ends it

replay = Show a recording with its original timing
replay-arg-file = The recording: .mcap or .pcapng
replay-arg-speed = Speed, times the original; 0 is without pauses (default 1)
replay-arg-serve = Send what the monitors sent to every program that connects here; the first one starts it

dissector = Print or install the dissector for Wireshark
dissector-arg-install = Install it where Wireshark looks for your plugins

completions = Print the completion script for a shell
completions-arg-shell = bash, elvish, fish, powershell or zsh

man = Print or write the manual pages
man-arg-out = Write a page for each command to this folder

schema = Print the dictionary of the protocol, or the API of the hub, as JSON
schema-arg-hub = The API of the hub (OpenAPI 3.1) instead of the dictionary
schema-arg-pretty = Print several lines, indented

# Names of the values, which the usage shows.
value-address = ADDRESS
value-board = BOARD
value-channel = CHANNEL
value-degrees = DEGREES
value-drive = DRIVE
value-drive-off-on-reject = DRIVE|off|on|reject
value-emulator = EMULATOR
value-f-l = F,L
value-factor = FACTOR
value-fault = FAULT
value-file = FILE
value-files = FILES
value-fire = FIRE
value-flow = FLOW
value-folder = FOLDER
value-form = FORM
value-glare = GLARE
value-h-v = H,V
value-h-v-m-ds = H,V,M,DS
value-hex-file = HEX|FILE
value-hosts = HOSTS
value-id = ID
value-image = IMAGE
value-item = ITEM
value-key = KEY
value-kind = KIND
value-lang = LANG
value-lat-lon = LATITUDE,LONGITUDE
value-layouts = LAYOUTS
value-list = LIST
value-metres = METRES
value-mm = MM
value-ms = MS
value-n-file = N=FILE
value-name = NAME
value-name-role-height = NAME=ROLE:HEIGHT
value-number = NUMBER
value-out = OUT
value-p-deg-m = P,DEG,M
value-page = PAGE
value-percent = PERCENT
value-port = PORT
value-position = POSITION
value-pressure = PRESSURE
value-program = PROGRAM
value-range = RANGE
value-request = REQUEST
value-role-name-height = ROLE:NAME:HEIGHT=X,Y,…
value-scenario = SCENARIO
value-seconds = SECONDS
value-share = SHARE
value-shell = SHELL
value-side = SIDE
value-slot = SLOT
value-speed = SPEED
value-subsystem = SUBSYSTEM
value-text = TEXT
value-unit = UNIT
value-user = USER
value-value = VALUE
value-valve = VALVE
value-version = VERSION
value-w-h = W,H
value-wall = WALL
value-where = WHERE
value-wxh = WxH
value-x-y-east-north = X,Y=EAST,NORTH
value-x-y-lat-lon = X,Y=LATITUDE,LONGITUDE
value-x-y-x-y-metres = X,Y,X,Y=METRES
