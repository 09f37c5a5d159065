## What the import of a site's drawing says: what is wrong and what to do, then what it shows.

problem-at-line = line { $line }: { $what } { $remedy }
problem-of-all = { $what } { $remedy }

# Files.
too-long = The file has { $bytes } bytes; { $most } at most are read.
too-much = The drawing has more than { $shapes } shapes or { $points } points.
too-many-layers = The drawing has more than { $most } layers.
too-much-remedy = Save a drawing of what is needed alone: tanks, walls, places.
other-format = This is { $name }, which is not read.
unknown-format = This begins like none of the formats that are read.
format-remedy = Save it as DXF, GeoJSON, SVG, PNG or JPEG.
broken-remedy = Save the drawing again in the program that it comes from.
cut = The file ends in the middle of the drawing.
cut-remedy = Copy it again: a part of it is missing.
no-code = A code of DXF is expected here, not `{ $shown }`.
no-number = The code { $code } needs a number, not `{ $shown }`.
no-sections = The file has no section of DXF.
not-complete = { $name } has no code { $code }.
too-deep = { $block } is nested deeper than { $most }, or contains itself.
too-deep-remedy = Explode the blocks, or resolve the references, and save again.
no-place = A coordinate is no number, or too large.
no-place-remedy = Delete what lies far from the site, and save again.
not-geo-json = This is not GeoJSON (column { $column }).
not-geo-json-remedy = Export it again as GeoJSON (RFC 7946).
wrong-coordinates = The coordinates of a { $kind } are not those of one.
not-utf8 = The text is not UTF-8.
not-utf8-remedy = Save it as SVG in UTF-8.
not-xml = This is no XML that can be read: { $said }.
no-svg = The file is XML, but no SVG.
entities = The entities that the file declares could become too long a text.
entities-remedy = Save it as plain SVG.
no-transform = `{ $shown }` is no transform.
no-length = { $name } = `{ $shown }` is no length.
no-path = A path is not understood: { $shown }.
picture-broken = The file begins like { $format }, but its size is not found.
picture-broken-remedy = Save the picture again.

# What is stated.
no-place-on-earth = There is no place with the latitude { $latitude } and the longitude { $longitude }.
no-place-on-earth-remedy = Latitude first (−90 to 90), then longitude (−180 to 180), in degrees. If the coordinates are metres, state --unit m.
too-far-from-zero = The place { $latitude }, { $longitude } is { $km } km from the zero of the site.
too-far-remedy = Check the zero: latitude first, then longitude. If the coordinates are metres, state --unit m.
picture-unit = A picture has pixels, no unit of length.
picture-unit-remedy = State --unit points, and two points or a distance that you know.
empty = There is nothing in this { $format } that is read.
empty-remedy = `lafet plan show` lists what was left out.
too-many-known = More than { $most } points or distances are stated.
known-remedy = Check the points and distances: places of the drawing first, then metres.
one-point = One known point gives no direction.
one-point-remedy = State two points, as far apart as possible, or --origin and --north.
points-and-north = Known points have the direction and the place already.
points-and-north-remedy = State either points, or --origin and --north.
no-zero = Where the zero of the site is on the Earth is not stated.
no-zero-remedy = State --zero LATITUDE,LONGITUDE, the same for all drawings of a site.
no-scale = The scale is 0.001 to 1000000.
no-scale-remedy = 500 is that of a drawing 1:500.
not-degrees = Only GeoJSON has degrees of WGS 84.
not-degrees-remedy = State the unit of length, and known points with --geo.
other-reference = The file names another reference system than WGS 84: { $name }.
other-reference-remedy = Export it in WGS 84 (EPSG:4326), or state the unit of its plane coordinates, as --unit m.
wgs84-alone = Degrees of WGS 84 are placed by --zero alone.
wgs84-alone-remedy = Leave out points, scale, origin and north.
points-missing = With --unit points the scale comes from what you know, and nothing is stated.
points-missing-remedy = State two points (--point) or a distance (--distance).
unit-differs = The drawing says that its unit is { $drawn }; you state { $stated }.
unit-differs-remedy = One of them is wrong. Measure something on the site and state it with --distance, or state two points: that decides.
too-near = The known points are less than { $percent } % of the drawing apart.
too-near-remedy = State points or a distance as far apart as possible.
scale-differs = By what you know the drawing is { $times } times as large as by its unit.
scale-differs-unit = That fits --unit { $unit }. Otherwise a point or distance is wrong.
scale-differs-remedy = Either the unit is wrong (a drawing on paper needs --scale), or a point or distance.
known-differ = What you know differs by the factor { $times } among itself.
points-off = A known point or distance is { $metres } m off ({ $percent } %).
points-off-remedy = Check each of them. If the drawing is mirrored, no turn fits it.
too-small = The drawing would be { $width } m × { $height } m.
too-small-remedy = No site is so small: the unit is wrong, or --scale is missing.
too-large = Something is { $km } km from the zero of the site.
too-large-remedy = Either the unit is wrong, or --origin is missing: the place of the drawing that is the zero of the site.
unit-missing = The unit of the drawing is not stated, and it is never guessed: state --unit ({ $names }).

# What becomes of it.
no-layer = The drawing has no layer `{ $layer }`.
no-layer-remedy = It has: { $known }.
no-height = The layer `{ $layer }` has something without a height.
no-height-remedy = State the height, m: --layer "{ $layer }={ $role }:12".
wrong-height = Something on the layer `{ $layer }` is { $metres } m high; allowed: up to { $most } m.
no-tank = Something round on the layer `{ $layer }` would have a diameter of { $metres } m: no tank has.
no-tank-remedy = Either the unit is wrong, or the layer is not that of the tanks.
mark-points = The mark `{ $name }` does not have the places that it needs.
mark-points-remedy = A tank has two: its centre and a place on its rim. A wall has two or more, a monitor or detector one.
too-many-found = More than { $most } of a kind.
too-many-found-remedy = Use fewer layers, or a simpler drawing.
left-out = Left out of `{ $layer }`: { $count }, { $why }.
why-not-round = not round
why-twice = a second time in the same place
why-short = shorter than 0.1 m
why-no-place = neither a point nor round
pieces-spots = Places for the [[{ $table }]] tables that you have or write:

# What is shown.
show-picture = { $format }: { $width } × { $height } pixels, from the upper left corner. It has no scale: state --unit points and two points or a distance.
show-proposed = { $format }. It says that its unit is { $unit }; that may be wrong: compare the sizes below with the site.
show-reference = { $format }. Its coordinates are those of { $name }.
show-no-unit = { $format }. It names no unit: compare the sizes below with the site.
show-paper = Size of the paper or screen: { $width } × { $height }.
show-extent = From { $x }, { $y } to { $to_x }, { $to_y } as drawn.
show-sizes = All that is drawn would be, with --unit:
size = { $width } m × { $height } m
show-layers = Layers:
show-layer = `{ $name }`: circles { $circles }, lines { $paths }, points { $points }
show-hidden = { " " }(off or frozen)
show-skipped = Not read, or empty: { $kinds }.
summary-size = { $format }, unit { $unit }: all that is drawn is { $width } m × { $height } m.
summary-north = North is { $north }° clockwise from the upper edge of the drawing.
summary-true-north = North is true north at the zero of the site.
summary-checked = Checked by what you know ({ $count }): off by { $worst } m at most ({ $percent } %); the scale differs by { $off } %.
summary-scaled = The scale is that of what you know ({ $count }): off by { $worst } m at most ({ $percent } %).
summary-unchecked = NOT CHECKED: no point or distance is known. Compare the size with the site.
summary-found = Tanks: { $tanks }, walls: { $walls }, places of monitors: { $monitors }, of detectors: { $detectors }.
summary-extent = They lie from { $west } to { $east } m east and from { $south } to { $north } m north of the zero.
summary-unused = Layers that are not used: { $names }.
summary-many = More than { $most } tanks and walls: the planner of the zones does not compute with so many.

# How something is written.
written-unit = one of { $names }
written-place = write X,Y: a place as drawn
written-point = write X,Y=EAST,NORTH: a place as drawn, and metres from the zero of the site
written-on-earth = write LATITUDE,LONGITUDE: degrees of WGS 84
written-geo = write X,Y=LATITUDE,LONGITUDE: a place as drawn, and degrees of WGS 84
written-distance = write X,Y,X,Y=METRES: two places as drawn, and their distance
written-layer = write NAME=ROLE or NAME=ROLE:HEIGHT, metres; roles: { $roles }
written-mark = write ROLE:NAME:HEIGHT=X,Y,X,Y…: places as drawn; roles: { $roles }
