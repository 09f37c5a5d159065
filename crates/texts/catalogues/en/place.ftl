## What the geometry of an installation refuses. What has bounds comes first: it is put in `out-of-range` or
## `too-many`.

out-of-range = { $what } is { $value }; allowed: { $least } … { $most }
too-many = { $count } { $what }; allowed: { $least } … { $most }

supply-flow = the flow of the supply, l/min,
curve-points = points of the curve
curve-flow = a flow of the curve, l/min,
curve-pressure = a pressure of the curve, MPa,
curve-not-falling = the curve starts at a flow of 0; from point to point the flow rises and the pressure does not

probability = the probability
stations = stations
bearings = bearings
floor-height = the height of the floor, m,
sights-parallel = the lines of sight do not cross, or hardly: bearings of two stations that see the fire from different sides are needed
bearings-apart = the bearings do not meet in one place: either there are several fires or a bearing is wrong, and it cannot be determined which

area-corner = a corner of the area, m,
area-extent = the extent of the area, m,
cell-side = the side of a cell, m,
plane-height = the height of the protected plane, m,
too-many-cells = { $cells } cells; allowed: { $most }. Take larger cells or a smaller area
winds = winds
flowing-monitors = monitors that flow together

fires = fires
monitor-states = states of monitors
barrel-direction = where a barrel points, rad,

fire-place = the place of a fire, m,
fire-area = the area of a fire, m²,
fire-density = the density for a fire, l/min/m²,

reference-fires = reference fires
reference-place = the place of a reference, m,
reference-distance = the distance of a reference, m,
reference-without-elevation = a reference without elevation: the tilt cannot be found
references-weak = these reference fires do not determine heading and tilt: place five or more, at least 40° apart from first to last, at different distances
alignment-unsettled = the alignment does not settle: check the places of the reference fires and their order
reference-wrong = reference { $number } does not fit the others: azimuth off by { $azimuth }°, elevation by { $elevation }°; check its place, and whether two references are interchanged

box-heading = the heading of a box, rad,
body-coordinate = a coordinate of a body, m,
body-size = a size of a body, m,
body-height = the height of a body from bottom to top, m,

station-place = the place of a station, m,
station-heading = the heading of a station, rad,
station-tilt = the tilt of a station, rad,
station-angle-error = the angle error of a station, rad,
station-height-error = the height error of a station, m,
station-unknown = a bearing of station { $station }; there are { $stations }
azimuth = an azimuth, rad,
elevation = an elevation, rad,
bearing-error = the error of a bearing, rad,
bearing-quality = the quality of a bearing
bearing-age = the age of a bearing, ms,

monitor-place = the place of a monitor, m,
nozzle-height = the height of a nozzle, m,
monitor-heading = the heading of a monitor, rad,
azimuth-limit = a limit of azimuth, rad,
elevation-limit = a limit of elevation, rad,
limits-reversed = the limits of a monitor: the first is below the second
outlet = an outlet, mm,
nozzle-position = the position of a nozzle, mm,
flow-at-1-mpa = a flow at 1 MPa, l/min,
drive-speed = the speed of a drive, rad/s,
sector-of-unknown-monitor = a keep-out sector of a monitor that does not exist
sector-angle = an angle of a sector, rad,
wind-direction = the direction of a wind, rad,
wind-speed = the speed of a wind, m/s,
monitors = monitors
obstacles = obstacles
keep-outs = keep-outs
monitor-clearance = the clearance around monitors, m,

rectangle-skew = the sides of a rectangle are not at right angles
disc-radius = the radius of a disc, m,
surface-coordinate = a coordinate of a surface, m,
normal-length = the length of a normal
surfaces = surfaces
one-station-needs-elevation = one station alone needs an elevation to give a place
sight-meets-nothing = the line of sight meets no surface
sight-too-flat = the line of sight meets the surface too flat to give a place
