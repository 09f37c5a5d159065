#!/usr/bin/env python3
"""Writes drawings of one site in many ways, by programs that are not ours, and the truth beside them.

    pip install ezdxf svgwrite pyproj pillow
    python3 make.py FOLDER

truth.json has the site in metres, computed here, and for each drawing what a person would state.
"""

import json
import math
import sys
from pathlib import Path

import ezdxf
import pyproj
import svgwrite
from ezdxf import units
from PIL import Image

# The site: metres east and north of its zero.
TANKS = [
    ("T-1", 12.5, 20.25, 8.0, 6.0),
    ("T-2", 33.75, 22.0, 11.5, 7.5),
    ("T-3", 61.2, 18.4, 22.8, 11.9),
    ("T-4", 15.0, 51.3, 8.0, 6.0),
    ("T-5", 38.9, 55.05, 15.18, 9.0),
]
BUILDING = [(70.0, 45.0), (94.0, 45.0), (94.0, 57.5), (70.0, 57.5)]
DIKE = [(2.0, 5.0), (80.0, 5.0), (80.0, 38.0)]
MONITORS = [("M1", -4.0, 2.5), ("M2", 97.25, 8.0), ("M3", 48.0, 70.0)]
WALL_M, DIKE_M, MONITOR_M = 8.0, 2.0, 3.5

FT = 0.3048
US_FT = 1200 / 3937
ZERO = (59.9386, 30.3141)


class Frame:
    """From the site to the drawing: a unit, a turn of north, an offset in units of the drawing."""

    def __init__(self, unit, north=0.0, offset=(0.0, 0.0), y=1.0):
        self.unit, self.north, self.offset, self.y = unit, north, offset, y

    def at(self, east, north):
        # North is drawn `self.north` degrees clockwise from up.
        angle = -math.radians(self.north)
        x = (math.cos(angle) * east - math.sin(angle) * north) / self.unit
        y = (math.sin(angle) * east + math.cos(angle) * north) / self.unit
        return (x + self.offset[0], self.y * (y + self.offset[1]))

    def length(self, metres):
        return metres / self.unit

    def point(self, east, north):
        """What a person states with --point."""
        x, y = self.at(east, north)
        return f"{x!r},{y!r}={east!r},{north!r}"

    def distance(self, a, b):
        (x, y), (u, v) = self.at(*a), self.at(*b)
        metres = math.hypot(a[0] - b[0], a[1] - b[1])
        return f"{x!r},{y!r},{u!r},{v!r}={metres!r}"


LAYERS = ["TANKS=tank", "WALLS=wall:8", "DIKE=wall:2", "MONITORS=monitor:3.5"]


def dxf(version="R2010", insunits=0, layers=True):
    doc = ezdxf.new(version)
    doc.header["$INSUNITS"] = insunits
    if layers:
        for name in ("TANKS", "WALLS", "DIKE", "MONITORS", "TEXT", "Разное"):
            doc.layers.add(name)
    return doc


def plain(doc, f, tanks=True, walls=True, monitors=True, thick=True):
    """Circles with a thickness, lines, points; texts name the tanks."""
    msp = doc.modelspace()
    if tanks:
        for name, e, n, d, h in TANKS:
            attribs = {"layer": "TANKS"}
            if thick:
                attribs["thickness"] = f.length(h)
            msp.add_circle(f.at(e, n), f.length(d / 2), dxfattribs=attribs)
            label = f.at(e - 1, n + 0.5)
            msp.add_text(name, height=f.length(1.0), dxfattribs={"layer": "TEXT"}).set_placement(label)
    if walls:
        ring = BUILDING + BUILDING[:1]
        for a, b in zip(ring, ring[1:]):
            msp.add_line(f.at(*a), f.at(*b), dxfattribs={"layer": "WALLS"})
        for a, b in zip(DIKE, DIKE[1:]):
            msp.add_line(f.at(*a), f.at(*b), dxfattribs={"layer": "DIKE"})
    if monitors:
        for _, e, n in MONITORS:
            msp.add_point(f.at(e, n), dxfattribs={"layer": "MONITORS"})
    return msp


out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)
drawings = []


def add(file, unit, **stated):
    """The file and what is stated; `decided`: something is known that refuses every other unit."""
    stated.setdefault("layers", LAYERS)
    for key in ("points", "geo", "distances", "marks"):
        stated.setdefault(key, [])
    drawings.append({"file": file, "unit": unit, **stated})


def save(doc, file, **how):
    doc.saveas(out / file, **how)


# 1 to 5: units as the header says them, or without.
f = Frame(0.001)
doc = dxf("R2010", units.MM)
plain(doc, f)
save(doc, "01-mm.dxf")
add("01-mm.dxf", "mm", decided=True)

f = Frame(1.0)
doc = dxf("R2000", units.M)
msp = plain(doc, f, walls=False)
msp.add_lwpolyline([f.at(*p) for p in BUILDING], close=True, dxfattribs={"layer": "WALLS"})
msp.add_lwpolyline([f.at(*p) for p in DIKE], dxfattribs={"layer": "DIKE"})
save(doc, "02-m.dxf")
add("02-m.dxf", "m", decided=True)

f = Frame(0.0254)
doc = dxf("R2013", units.IN)
plain(doc, f)
save(doc, "03-inch.dxf")
add("03-inch.dxf", "in", decided=True)

f = Frame(0.01)
doc = dxf("R2018", 0)
plain(doc, f)
save(doc, "04-cm-unitless.dxf")
add("04-cm-unitless.dxf", "cm", distances=[f.distance((2.0, 5.0), (94.0, 57.5))], decided=True)

f = Frame(FT)
doc = dxf("R2010", units.FT)
plain(doc, f)
save(doc, "05-feet-binary.dxf", fmt="bin")
add("05-feet-binary.dxf", "ft", decided=True)

# 6, 7: rotated.
f = Frame(0.001, north=30.0, offset=(125000.0, -40000.0))
doc = dxf("R2010", units.MM)
plain(doc, f)
save(doc, "06-mm-north-30.dxf")
origin = f.at(0, 0)
add("06-mm-north-30.dxf", "mm", north=30.0, origin=f"{origin[0]!r},{origin[1]!r}", decided=True)

f = Frame(1.0, north=-77.3, offset=(7412345.678, 6123456.789))
doc = dxf("R2010", 0)
plain(doc, f)
save(doc, "07-m-national-grid.dxf")
add("07-m-national-grid.dxf", "m", points=[f.point(2.0, 5.0), f.point(94.0, 57.5)], decided=True)


# 8 to 10: blocks.
def symbol(doc, name="MON"):
    block = doc.blocks.new(name)
    block.add_circle((0, 0), 1, dxfattribs={"layer": "0"})
    block.add_line((-1, 0), (1, 0), dxfattribs={"layer": "0"})
    block.add_attdef("ID", (0, 0))
    return block


f = Frame(0.001, north=12.0)
doc = dxf("R2010", units.MM)
msp = plain(doc, f, tanks=False, monitors=False)
tank = doc.blocks.new("TANK", base_point=(500, 250))
tank.add_circle((500, 250), 500, dxfattribs={"layer": "0"})
tank.add_attdef("NAME", (500, 250))
symbol(doc)
for name, e, n, d, h in TANKS:
    scale = f.length(d) / 1000
    insert = msp.add_blockref(
        "TANK", f.at(e, n),
        dxfattribs={"layer": "TANKS", "xscale": scale, "yscale": scale, "rotation": 33.0},
    )
    insert.add_attrib("NAME", name, f.at(e, n))
for name, e, n in MONITORS:
    insert = msp.add_blockref("MON", f.at(e, n), dxfattribs={"layer": "MONITORS", "rotation": 90})
    insert.add_attrib("ID", name, f.at(e, n))
save(doc, "08-mm-blocks.dxf")
tall = ["TANKS=tank:9", "WALLS=wall:8", "DIKE=wall:2", "MONITORS=monitor:3.5"]
add("08-mm-blocks.dxf", "mm", north=12.0, layers=tall, height=9.0, named=True, decided=True)

# Blocks in blocks: the whole site is one, turned and moved.
f = Frame(1.0)
doc = dxf("R2007", units.M)
inner = doc.blocks.new("FARM", base_point=(5, 7))
inner_tank = doc.blocks.new("UNIT")
inner_tank.add_circle((0, 0), 0.5, dxfattribs={"layer": "0"})
for name, e, n, d, h in TANKS:
    inner.add_blockref("UNIT", (e + 5, n + 7), dxfattribs={"layer": "TANKS", "xscale": d, "yscale": d})
inner.add_lwpolyline([(e + 5, n + 7) for e, n in BUILDING], close=True, dxfattribs={"layer": "WALLS"})
inner.add_lwpolyline([(e + 5, n + 7) for e, n in DIKE], dxfattribs={"layer": "DIKE"})
for _, e, n in MONITORS:
    doc.modelspace().add_point(Frame(1.0, north=-25.0, offset=(300, 200)).at(e, n), dxfattribs={"layer": "MONITORS"})
doc.modelspace().add_blockref("FARM", (300, 200), dxfattribs={"rotation": 25.0, "layer": "0"})
save(doc, "09-m-nested-blocks.dxf")
add("09-m-nested-blocks.dxf", "m", north=-25.0, origin="300,200", layers=tall, height=9.0, decided=True)

# Mirrored: blocks with a negative scale, circles on planes that look down.
f = Frame(0.001)
doc = dxf("R2010", units.MM)
msp = plain(doc, f, tanks=False)
half = doc.blocks.new("HALF")
for name, e, n, d, h in TANKS[:2]:
    x, y = f.at(e, n)
    half.add_circle((-x, y), f.length(d / 2), dxfattribs={"layer": "TANKS"})
msp.add_blockref("HALF", (0, 0), dxfattribs={"xscale": -1.0})
for name, e, n, d, h in TANKS[2:]:
    x, y = f.at(e, n)
    msp.add_circle((-x, y), f.length(d / 2), dxfattribs={"layer": "TANKS", "extrusion": (0, 0, -1)})
save(doc, "10-mm-mirrored.dxf")
add("10-mm-mirrored.dxf", "mm", layers=tall, height=9.0, decided=True)

# 11: release 12, arcs as bulges, inches without a word of it.
f = Frame(0.0254, north=45.0)
doc = dxf("R12", 0)
msp = plain(doc, f, tanks=False, walls=False)
for name, e, n, d, h in TANKS:
    (x, y), r = f.at(e, n), f.length(d / 2)
    msp.add_polyline2d(
        [(x - r, y, 1.0), (x + r, y, 1.0)], format="xyb", close=True,
        dxfattribs={"layer": "TANKS", "thickness": f.length(h)},
    )
msp.add_polyline2d([f.at(*p) for p in BUILDING], close=True, dxfattribs={"layer": "WALLS"})
msp.add_polyline2d([f.at(*p) for p in DIKE], dxfattribs={"layer": "DIKE"})
save(doc, "11-inch-r12-bulges.dxf")
add("11-inch-r12-bulges.dxf", "in", points=[f.point(-4.0, 2.5), f.point(97.25, 8.0), f.point(48.0, 70.0)], decided=True)

# 12: ellipses, the whole way round, in millimetres.
f = Frame(0.001)
doc = dxf("R2010", units.MM)
msp = plain(doc, f, tanks=False)
for name, e, n, d, h in TANKS:
    r = f.length(d / 2)
    msp.add_ellipse(f.at(e, n), (r * 0.6, r * 0.8), 1.0, dxfattribs={"layer": "TANKS"})
save(doc, "12-mm-ellipses.dxf")
add("12-mm-ellipses.dxf", "mm", layers=tall, height=9.0, decided=True)

# 13: heights from the ground, which is 142 m above the sea; walls as lines in space.
f = Frame(1.0)
doc = dxf("R2010", units.M)
msp = plain(doc, f, tanks=False, walls=False)
for name, e, n, d, h in TANKS:
    msp.add_circle((e, n, 142.0), d / 2, dxfattribs={"layer": "TANKS", "thickness": h})
ring = BUILDING + BUILDING[:1]
msp.add_polyline3d([(e, n, 142.0) for e, n in ring], dxfattribs={"layer": "WALLS"})
msp.add_polyline3d([(e, n, 142.0) for e, n in DIKE], dxfattribs={"layer": "DIKE"})
save(doc, "13-m-above-sea.dxf")
add("13-m-above-sea.dxf", "m", ground=142.0, decided=True)

# 14: the header is wrong.
f = Frame(0.001)
doc = dxf("R2010", units.IN)
plain(doc, f)
save(doc, "14-mm-says-inch.dxf")
add("14-mm-says-inch.dxf", "mm", distances=[f.distance((-4.0, 2.5), (94.0, 57.5))], decided=True)

# 15: feet of the US surveys.
f = Frame(US_FT, north=5.0, offset=(2000000.0, 700000.0))
doc = dxf("R2010", 21)
plain(doc, f)
save(doc, "15-us-feet.dxf")
add("15-us-feet.dxf", "us-ft", points=[f.point(2.0, 5.0), f.point(80.0, 38.0), f.point(70.0, 57.5)], decided=True)

# 16, 17: GeoJSON.
GEOD = pyproj.Geod(ellps="WGS84")


def lonlat(e, n):
    azimuth, distance = math.degrees(math.atan2(e, n)), math.hypot(e, n)
    lon, lat, _ = GEOD.fwd(ZERO[1], ZERO[0], azimuth, distance)
    return [lon, lat]


def geojson(at, around, crs=None):
    features = []

    def feature(layer, kind, coordinates, **properties):
        features.append({
            "type": "Feature",
            "properties": {"layer": layer, **properties},
            "geometry": {"type": kind, "coordinates": coordinates},
        })

    for name, e, n, d, h in TANKS:
        ring = [around(e, n, d / 2, 360 * k / 64) for k in range(64)]
        feature("TANKS", "Polygon", [ring + ring[:1]], name=name, height=h)
    feature("WALLS", "Polygon", [[at(*p) for p in BUILDING + BUILDING[:1]]])
    feature("DIKE", "LineString", [at(*p) for p in DIKE])
    feature("MONITORS", "MultiPoint", [at(e, n) for _, e, n in MONITORS])
    collection = {"type": "FeatureCollection", "features": features}
    if crs:
        collection["crs"] = {"type": "name", "properties": {"name": crs}}
    return collection


def rim(e, n, r, angle):
    lon, lat = lonlat(e, n)
    lon, lat, _ = GEOD.fwd(lon, lat, angle, r)
    return [lon, lat]


(out / "16-wgs84.geojson").write_text(json.dumps(geojson(lonlat, rim)))
add("16-wgs84.geojson", "wgs84", zero=f"{ZERO[0]},{ZERO[1]}", named=True, decided=True)

UTM = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:32636", always_xy=True)
grid = lambda e, n: list(UTM.transform(*lonlat(e, n)))
grid_rim = lambda e, n, r, angle: list(UTM.transform(*rim(e, n, r, angle)))
name = "urn:ogc:def:crs:EPSG::32636"
(out / "17-utm.geojson").write_text(json.dumps(geojson(grid, grid_rim, name)))


def geo(e, n):
    (x, y), (lon, lat) = grid(e, n), lonlat(e, n)
    return f"{x!r},{y!r}={lat!r},{lon!r}"


add("17-utm.geojson", "m", zero=f"{ZERO[0]},{ZERO[1]}", geo=[geo(2.0, 5.0), geo(94.0, 57.5)], named=True, decided=True)

# 18: paper, 1:500, millimetres, in nested groups with transforms.
paper = svgwrite.Drawing(out / "18-paper-1-500.svg", size=("297mm", "210mm"), viewBox="0 0 297 210")
f = Frame(0.5, north=20.0, offset=(30.0, -180.0), y=-1.0)
sheet = paper.g(id="sheet", transform="translate(10 5)")
layers = {name: paper.g(id=name) for name in ("TANKS", "WALLS", "DIKE", "MONITORS")}
shifted = lambda e, n: (f.at(e, n)[0] - 10, f.at(e, n)[1] - 5)
for name, e, n, d, h in TANKS:
    layers["TANKS"].add(paper.circle(shifted(e, n), d / 2 / f.unit))
layers["WALLS"].add(paper.polygon([shifted(*p) for p in BUILDING]))
turned = paper.g(transform="rotate(30) scale(2)")


def unturned(e, n):
    x, y = shifted(e, n)
    a = math.radians(-30)
    return ((math.cos(a) * x - math.sin(a) * y) / 2, (math.sin(a) * x + math.cos(a) * y) / 2)


turned.add(paper.path("M" + " L".join("%.9f %.9f" % unturned(*p) for p in DIKE)))
layers["DIKE"].add(turned)
for _, e, n in MONITORS:
    layers["MONITORS"].add(paper.circle(shifted(e, n), 0.5))
for layer in layers.values():
    moved = paper.g(transform="translate(10 5)")
    layer_group = paper.g(id=layer["id"])
    for element in layer.elements:
        moved.add(element)
    layer_group.add(moved)
    paper.add(layer_group)
paper.save()
origin = f.at(0, 0)
add("18-paper-1-500.svg", "mm", scale=500.0, north=20.0, origin=f"{origin[0]!r},{origin[1]!r}",
    layers=tall, height=9.0, distances=[f.distance((2.0, 5.0), (94.0, 57.5))], decided=True)

# 19: pixels of a screen, tanks as paths of arcs.
f = Frame(0.125, north=-64.0, offset=(100.0, -900.0), y=-1.0)
screen = svgwrite.Drawing(out / "19-pixels.svg", size=("1200px", "1000px"))
groups = {name: screen.g(id=name) for name in ("TANKS", "WALLS", "DIKE", "MONITORS")}
for name, e, n, d, h in TANKS:
    (x, y), r = f.at(e, n), f.length(d / 2)
    groups["TANKS"].add(screen.path(f"M{x - r} {y}a{r} {r} 0 1 0 {2 * r} 0a{r} {r} 0 1 0 {-2 * r} 0z"))
groups["WALLS"].add(screen.polygon([f.at(*p) for p in BUILDING]))
groups["DIKE"].add(screen.polyline([f.at(*p) for p in DIKE], fill="none"))
for _, e, n in MONITORS:
    groups["MONITORS"].add(screen.circle(f.at(e, n), 3))
for group in groups.values():
    screen.add(group)
screen.save()
add("19-pixels.svg", "points", points=[f.point(2.0, 5.0), f.point(94.0, 57.5)], layers=tall, height=9.0)


# 20, 21: a plan from a scanner, and a photograph of an upright camera.
def marks(f):
    written = []
    for name, e, n, d, h in TANKS:
        (x, y), (u, v) = f.at(e, n), f.at(e + d / 2, n)
        written.append(f"tank:{name}:{h}={x},{y},{u},{v}")
    flat = lambda points: ",".join(f"{x},{y}" for x, y in (f.at(*p) for p in points))
    written.append(f"wall:WALLS:8={flat(BUILDING + BUILDING[:1])}")
    written.append(f"wall:DIKE:2={flat(DIKE)}")
    for name, e, n in MONITORS:
        written.append(f"monitor:{name}:3.5={flat([(e, n)])}")
    return written


f = Frame(0.05, north=90.0, offset=(300.0, -1500.0), y=-1.0)
Image.new("1", (2200, 2600)).save(out / "20-scan.png")
add("20-scan.png", "points", points=[f.point(2.0, 5.0), f.point(94.0, 57.5)], layers=[], marks=marks(f),
    named=True, pixels=[2200, 2600])
f = Frame(0.1, north=3.0, offset=(80.0, -900.0), y=-1.0)
exif = Image.Exif()
exif[0x0112] = 6
Image.new("L", (1200, 1000)).save(out / "21-photograph.jpg", exif=exif, quality=10)
add("21-photograph.jpg", "points", distances=[f.distance((2.0, 5.0), (94.0, 57.5))], north=3.0,
    origin=",".join(repr(it) for it in f.at(0, 0)), layers=[], marks=marks(f), named=True, pixels=[1000, 1200])

# 22: Cyrillic names in a code page, rows and columns of a block.
f = Frame(0.001)
doc = dxf("R2000", units.MM)
doc.header["$DWGCODEPAGE"] = "ANSI_1251"
doc.encoding = "cp1251"
doc.layers.add("РЕЗЕРВУАРЫ")
msp = doc.modelspace()
one = doc.blocks.new("РВС")
one.add_circle((0, 0), 4000, dxfattribs={"layer": "0"})
msp.add_blockref("РВС", (10000, 20000), dxfattribs={
    "layer": "РЕЗЕРВУАРЫ", "rotation": 90.0, "column_count": 3, "row_count": 2,
    "column_spacing": 12000, "row_spacing": 15000})
save(doc, "22-rows-cp1251.dxf")
rows = [["РЕЗЕРВУАРЫ-%d" % (1 + k), 10.0 - 15.0 * (k // 3), 20.0 + 12.0 * (k % 3), 8.0, 6.0] for k in range(6)]
add("22-rows-cp1251.dxf", "mm", layers=["резервуары=tank:6"], tanks=rows, alone=True, decided=True)

site = {
    "tanks": TANKS,
    "walls": [[*a, *b, WALL_M] for a, b in zip(ring, ring[1:])] + [[*a, *b, DIKE_M] for a, b in zip(DIKE, DIKE[1:])],
    "monitors": [[e, n, MONITOR_M] for _, e, n in MONITORS],
    "extent": [101.25, 67.5],
}
(out / "truth.json").write_text(json.dumps({"site": site, "drawings": drawings}, ensure_ascii=False, indent=1))
