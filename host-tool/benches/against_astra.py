"""Runs Vitrine and the ASTRA Toolbox to the same quality on the paper's three views and prints both times.

    pip install astra-toolbox==2.5.0 numpy imageio
    cargo build --release -p vitrine --bin vitrine --example figures
    python3 host-tool/benches/against_astra.py target/release

Code values, ideal optics, parallel rays: every row of pixels is a problem of its own, a volume of 20 x 512 non-square
pixels (0.6 mm x 0.068 mm) seen from three directions. ASTRA's CPU projector `linear` along `parallel_vec` rays is the
same operator but for a ray's length, which is divided out; that is checked first. ASTRA follows a ray from film to film
by adding a step to its place in single precision, which near pixel 512 tells 3e-5 of a pixel: at 30 degrees the rounded
steps add up to 1e-4 of a pixel. So the outer views stand at 29.976 degrees, where a step is 324 / 64 of a pixel and no
step is rounded: there the operators agree to 1e-7. What 30 degrees would differ by is told, too. ASTRA's SIRT runs within 0..1 on some of the rows until their gain-fitted PSNR is what Vitrine's films reach on the same rows;
its time is that of one row times the number of rows. Both have one core, and times are the processor's, which a busy
machine does not change much; Vitrine's is all that its process takes, with reading the patterns and measuring the films.
"""
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import astra
import imageio.v3 as iio
import numpy as np

PIXELS, FILMS, PITCH_MM, WIDTH_MM, BRIGHTNESS = 512, 20, 0.6, 35.0, 0.4
PIXEL_MM = WIDTH_MM / PIXELS
OUTER_DEG = float(np.degrees(np.arctan(324 / 64 * PIXEL_MM / PITCH_MM)))
VIEWS = [("astronaut", OUTER_DEG), ("coffee", 0.0), ("cat", -OUTER_DEG)]
ROWS = range(16, 512, 64)
PHOTOS = pathlib.Path(__file__).parent.parent / "photos"


def exhibit():
    views = "".join(f'[[view]]\nid = "{name}"\npattern = "{PHOTOS / name}.jpg"\nhorizontal_deg = {angle}\n' for name, angle in VIEWS)
    return '[exhibit]\nname = "ASTRA"\n' + views + '[design]\noptics = "ideal"\ntone = "code"\niterations = 10\n'


def vitrine(folder):
    """Films (row, film, column, channel) and the seconds of a process that designs them."""
    alone = dict(os.environ, RAYON_NUM_THREADS="1")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([folder / "examples" / "figures", "code-three", "--iterations", "10"], env=alone, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        (work / "exhibit.toml").write_text(exhibit())
        subprocess.run([folder / "vitrine", "design", "exhibit.toml", "-o", "build"], cwd=work, check=True, capture_output=True)
        films = np.stack([iio.imread(film) / 255.0 for film in sorted((work / "build" / "films").glob("*.png"))], 1)
        return films[..., :3].astype(np.float32), seconds


def matrix(angle):
    """Our operator, row of a picture x (film, column), by architecture's formula."""
    operator = np.zeros((PIXELS, FILMS, PIXELS))
    for film in range(FILMS):
        z = ((FILMS - 1) / 2 - film) * PITCH_MM
        places = np.arange(PIXELS) + z * np.tan(np.radians(angle)) / PIXEL_MM
        lower = np.floor(places + 1e-9).astype(int)
        part = np.maximum(places - lower, 0)
        for offset, weight in ((0, 1 - part), (1, part)):
            inside = (lower + offset >= 0) & (lower + offset < PIXELS)
            operator[np.arange(PIXELS)[inside], film, (lower + offset)[inside]] += weight[inside]
    return operator.reshape(PIXELS, -1)


def geometry(angles):
    volume = astra.create_vol_geom(FILMS, PIXELS, -WIDTH_MM / 2, WIDTH_MM / 2, -FILMS * PITCH_MM / 2, FILMS * PITCH_MM / 2)
    slopes = np.tan(np.radians(angles))
    rays = np.array([[-slope, -1.0, 0.0, 0.0, PIXEL_MM, 0.0] for slope in slopes])
    return volume, astra.create_proj_geom("parallel_vec", PIXELS, rays)


def length(angle):
    """Of a ray within a pixel. It is longer the more it slants; ASTRA 2.5 takes it from the pixel's width."""
    return PIXEL_MM / np.cos(np.radians(angle))


def differences(projector, angles):
    """How far ASTRA's operator is from ours in each direction, as a part of ours."""
    theirs = astra.matrix.get(astra.projector.matrix(projector)).tocsr()
    for view, angle in enumerate(angles):
        ours = matrix(angle)
        their = theirs[view * PIXELS:(view + 1) * PIXELS].toarray() / length(angle)
        yield np.linalg.norm(their - ours) / np.linalg.norm(ours)


def fitted_error(shown, wanted):
    """Sums of the gain-fitted squared errors need all rows: returns what the gain is made of."""
    return (shown * wanted).sum(), (shown * shown).sum(), (wanted * wanted).sum(), wanted.size


def psnr(parts):
    product, square, wanted, count = np.sum(parts, axis=0)
    return -10 * np.log10((wanted - product**2 / square) / count)


def main():
    films, vitrine_seconds = vitrine(pathlib.Path(sys.argv[1]).resolve())
    patterns = [iio.imread(PHOTOS / f"{name}.jpg")[..., :3].astype(np.float32) / 255.0 for name, _ in VIEWS]
    angles = [angle for _, angle in VIEWS]
    operators = [matrix(angle).astype(np.float32) for angle in angles]

    volume, rays = geometry(angles)
    projector = astra.create_projector("linear", rays, volume)
    worst = max(differences(projector, angles))
    round_angles = [30.0, 0.0, -30.0]
    rounded = max(differences(astra.create_projector("linear", *reversed(geometry(round_angles))), round_angles))
    print(f"operators differ by {worst:.1e} of their norm, and at 30 degrees by {rounded:.1e}")
    assert worst < 1e-6

    def quality(volumes):
        means = []
        for view, operator in enumerate(operators):
            parts = [fitted_error(operator @ voxels.ravel(), patterns[view][row, :, channel]) for (row, channel), voxels in volumes.items()]
            means.append(psnr(parts))
        return np.mean(means)

    wanted = quality({(row, channel): films[row, :, :, channel] for row in ROWS for channel in range(3)})

    states, seconds = {}, 0.0
    for row in ROWS:
        for channel in range(3):
            sino = np.stack([BRIGHTNESS * FILMS * length(angle) * patterns[view][row, :, channel] for view, angle in enumerate(angles)])
            data, target = astra.data2d.create("-vol", volume, 0.0), astra.data2d.create("-sino", rays, sino)
            config = astra.astra_dict("SIRT")
            config.update(ProjectorId=projector, ReconstructionDataId=data, ProjectionDataId=target)
            config["option"] = {"MinConstraint": 0.0, "MaxConstraint": 1.0}
            states[row, channel] = (data, astra.algorithm.create(config))
    iterations, reached = 0, 0.0
    while reached < wanted and iterations < 5000:
        step = 10
        for data, algorithm in states.values():
            begin = time.process_time()
            astra.algorithm.run(algorithm, step)
            seconds += time.process_time() - begin
        iterations += step
        reached = quality({key: astra.data2d.get(data) for key, (data, _) in states.items()})
    whole = seconds * PIXELS / len(ROWS)
    print(f"Vitrine: {wanted:.2f} dB on these rows in {vitrine_seconds:.2f} s")
    print(f"ASTRA's SIRT: {reached:.2f} dB after {iterations} iterations, {whole:.1f} s for all rows")
    print(f"ratio: {whole / vitrine_seconds:.0f}")


if __name__ == "__main__":
    main()
