"""Contours a height image with other programs: their time, and whether they find the same vertices.

Arguments: a folder with levels.npy (rows x columns of levels, NaN where missing) and vertices.npy
(plane, column, row of every vertex in pixels), how many planes there are, and how many rounds to time.
Prints one line per program: name, nanoseconds per pixel for all planes, and the comparison.
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
    print(f"contourpy {contourpy.__version__}\t{took}\t{compare(lines_of, vertices, used)}")


def with_gdal(image, rounds, used, all_count, vertices):
    from osgeo import gdal, ogr

    gdal.UseExceptions()
    ogr.UseExceptions()
    rows, cols = image.shape
    raster = gdal.GetDriverByName("MEM").Create("", cols, rows, 1, gdal.GDT_Float32)
    raster.SetGeoTransform((-0.5, 1, 0, -0.5, 0, 1))
    band = raster.GetRasterBand(1)
    band.WriteArray(image.astype(np.float32))

    def run(levels):
        source = ogr.GetDriverByName("Memory").CreateDataSource("out")
        layer = source.CreateLayer("lines")
        layer.CreateField(ogr.FieldDefn("id", ogr.OFTInteger))
        layer.CreateField(ogr.FieldDefn("elev", ogr.OFTReal))
        gdal.ContourGenerate(band, 0, 0, [float(v) for v in levels], 1, float("nan"), 0, 1, layer)

    took = seconds(run, used, rounds) * all_count / len(used) / image.size * 1e9
    print(f"GDAL {gdal.__version__}\t{took}\tnot compared: it shifts levels that meet a pixel")


def main():
    folder, count, rounds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    image = np.load(f"{folder}/levels.npy").astype(np.float64)
    vertices = np.load(f"{folder}/vertices.npy")
    low, high = np.ceil(np.nanmin(image)), np.ceil(np.nanmax(image)) - 1
    levels = np.arange(low, high + 1)
    used = levels[np.unique(np.linspace(0, len(levels) - 1, MOST_LEVELS).round().astype(int))]
    for program in (with_contourpy, with_gdal):
        try:
            program(image, rounds, used, len(levels), vertices)
        except ImportError as error:
            print(f"{program.__name__[5:]} skipped: {error}", file=sys.stderr)


main()
