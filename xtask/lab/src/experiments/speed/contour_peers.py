"""Contours a height image with another program: its time, and whether it finds the same vertices.

Arguments: the program (contourpy or GDAL), a folder, the number of planes, and the number of timed
rounds. The folder has levels.npy: rows x columns of levels, NaN where missing. It also has
vertices.f64: plane, column and row of every vertex, in pixels. Prints one line: nanoseconds per
pixel for all planes, and the comparison.
"""

import sys
import time

import numpy as np

MOST_LEVELS = 64


def same_points(ours, theirs):
    """Largest distance between two sets of points, or None if they differ in number."""
    if len(ours) != len(theirs):
        return None
    # A projection that no two points share, but by accident.
    axis = np.array([0.7548776662466927, 0.5698402909980532])
    ours = ours[np.argsort(ours @ axis, kind="stable")]
    theirs = theirs[np.argsort(theirs @ axis, kind="stable")]
    apart = np.hypot(*(ours - theirs).T)
    swapped = np.nonzero(apart > 1e-6)[0]
    for k in swapped:
        apart[k] = np.hypot(*(theirs[swapped] - ours[k]).T).min()
    return apart.max() if len(apart) else 0.0


def compare(lines_of, vertices, levels):
    worst, count, unequal = 0.0, 0, 0
    for level in levels:
        ours = vertices[vertices[:, 0] == level, 1:]
        theirs = []
        for line in lines_of(level):
            closed = len(line) > 1 and np.array_equal(line[0], line[-1])
            theirs.append(line[:-1] if closed else line)
        theirs = np.concatenate(theirs) if theirs else np.zeros((0, 2))
        apart = same_points(ours, theirs)
        count += len(ours)
        if apart is None:
            unequal += 1
            print(f"  level {level}: {len(ours)} and {len(theirs)} vertices", file=sys.stderr)
        else:
            worst = max(worst, apart)
    verdict = f"{count} vertices on {len(levels)} planes"
    if unequal:
        return f"UNEQUAL on {unequal} planes, {verdict}"
    return f"equal {verdict}, largest distance {worst:.1e} pixel"


def seconds(run, levels, rounds):
    times = []
    for _ in range(rounds):
        start = time.thread_time()
        run(levels)
        times.append(time.thread_time() - start)
    return float(np.median(times))


def with_contourpy(image, rounds, used, all_count, vertices):
    import contourpy

    masked = np.ma.masked_invalid(image)
    z = masked if masked.mask.any() else image
    options = {"corner_mask": True} if masked.mask.any() else {}

    def lines_of(level):
        return contourpy.contour_generator(z=z, name="serial", **options).lines(level)

    def run(levels):
        generator = contourpy.contour_generator(z=z, name="serial", **options)
        for level in levels:
            generator.lines(level)

    took = seconds(run, used, rounds) * all_count / len(used) / image.size * 1e9
    print(f"{took}\t{compare(lines_of, vertices, used)}; contourpy {contourpy.__version__}")


def with_gdal(image, rounds, used, all_count, vertices):
    from osgeo import gdal, ogr

    gdal.UseExceptions()
    ogr.UseExceptions()
    rows, cols = image.shape
    missing = float(np.nanmin(image) - 1e3)
    raster = gdal.GetDriverByName("MEM").Create("", cols, rows, 1, gdal.GDT_Float64)
    raster.SetGeoTransform((-0.5, 1, 0, -0.5, 0, 1))
    band = raster.GetRasterBand(1)
    band.SetNoDataValue(missing)
    values = np.where(np.isnan(image), missing, image)
    band.WriteRaster(0, 0, cols, rows, values.tobytes())

    # All levels in one call, in regular steps: its fastest way.
    def run(_):
        source = ogr.GetDriverByName("Memory").CreateDataSource("out")
        layer = source.CreateLayer("lines", None, ogr.wkbLineString)
        layer.CreateField(ogr.FieldDefn("level", ogr.OFTReal))
        options = ["LEVEL_INTERVAL=1", "LEVEL_BASE=0", f"NODATA={missing!r}", "ELEV_FIELD=0"]
        gdal.ContourGenerateEx(band, layer, options=options)
        return source, layer

    took = seconds(run, used, rounds) / image.size * 1e9
    _source, layer = run(used)
    lines = {}
    for feature in layer:
        points = np.array(feature.GetGeometryRef().GetPoints())[:, :2]
        lines.setdefault(feature.GetField(0), []).append(points)
    print(f"{took}\t{shared(lines, vertices, used, image)}; GDAL {gdal.__version__}")


def keys(points, shift):
    """Numbers of the squares of 1e-5 pixel, shifted by parts of one, that points are in."""
    column, row = np.floor(points * 1e5 + shift).astype(np.int64).T
    return (column << 32) ^ row


def inside(points, image):
    """Which points are in no cell with a missing pixel and none at the border: there, GDAL adds half cells."""
    rows, cols = image.shape
    missing = np.pad(np.isnan(image), 2, constant_values=True)
    column, row = np.floor(points + 1e-9).astype(int).T
    near = np.zeros(len(points), bool)
    for i in (-1, 0, 1, 2):
        for j in (-1, 0, 1, 2):
            near |= missing[np.clip(row + i + 2, 0, rows + 3), np.clip(column + j + 2, 0, cols + 3)]
    return ~near


def shared(lines, vertices, levels, image):
    """How many vertices away from gaps and borders both have, and how many only one of them."""
    counts = np.zeros(3, int)
    for level in levels:
        ours = vertices[vertices[:, 0] == level, 1:]
        theirs = np.concatenate(lines.get(level, [np.zeros((0, 2))]))
        sides = [points[inside(points, image)] for points in (ours, theirs)]
        found = [np.zeros(len(points), bool) for points in sides]
        for shift in ((0, 0), (0, 0.5), (0.5, 0), (0.5, 0.5)):
            numbers = [keys(points, np.array(shift)) for points in sides]
            found[0] |= np.isin(numbers[0], numbers[1])
            found[1] |= np.isin(numbers[1], numbers[0])
        counts += [found[0].sum(), (~found[0]).sum(), (~found[1]).sum()]
    both, only_ours, only_theirs = counts
    return (
        f"away from gaps and borders on {len(levels)} planes, both have {both} vertices within 1e-5 pixel, "
        f"one pass alone {only_ours}, GDAL alone {only_theirs}"
    )


PROGRAMS = {"contourpy": with_contourpy, "GDAL": with_gdal}


def main():
    program, folder, count, rounds = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    image = np.load(f"{folder}/levels.npy").astype(np.float64)
    vertices = np.fromfile(f"{folder}/vertices.f64", "<f8").reshape(-1, 3)
    low, high = np.ceil(np.nanmin(image)), np.ceil(np.nanmax(image)) - 1
    levels = np.arange(low, high + 1)
    used = levels[np.unique(np.linspace(0, len(levels) - 1, MOST_LEVELS).round().astype(int))]
    PROGRAMS[program](image, rounds, used, len(levels), vertices)


main()
