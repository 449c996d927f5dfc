"""Runs Vitrine and the ASTRA Toolbox to the same quality on the paper's three views and prints both times.

    pip install astra-toolbox==2.5.0 numpy imageio
    cargo build --release -p vitrine --bin vitrine --example figures
    python3 host-tool/benches/against_astra.py target/release

Code values, ideal optics, parallel rays: every row of pixels is a problem of its own, a volume of 20 x 512 non-square
pixels (0.6 mm x 0.068 mm) seen from three directions. ASTRA's CPU projector `linear` along `parallel_vec` rays is the
same operator but for a ray's length, which is divided out, and for ASTRA's single precision; that is checked first. Its
SIRT runs within 0..1 on some of the rows until their gain-fitted PSNR is what Vitrine's films reach on the same rows;
its time is that of one row times the number of rows. Vitrine's time is the engine's, from patterns to films. Both have
one core.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import astra
import imageio.v3 as iio
import numpy as np

PIXELS, FILMS, PITCH_MM, WIDTH_MM, BRIGHTNESS = 512, 20, 0.6, 35.0, 0.4
VIEWS = [("astronaut", 30.0), ("coffee", 0.0), ("cat", -30.0)]
ROWS = range(16, 512, 64)
PIXEL_MM = WIDTH_MM / PIXELS
PHOTOS = pathlib.Path(__file__).parent.parent / "photos"


def exhibit():
    views = "".join(f'[[view]]\nid = "{name}"\npattern = "{PHOTOS / name}.jpg"\nhorizontal_deg = {angle}\n' for name, angle in VIEWS)
    return '[exhibit]\nname = "ASTRA"\n' + views + '[design]\noptics = "ideal"\ntone = "code"\niterations = 10\n'


def vitrine(folder):
    """Films (row, film, column, channel) and the engine's seconds."""
    alone = dict(os.environ, RAYON_NUM_THREADS="1")
    said = subprocess.run([folder / "examples" / "figures", "code-three", "--iterations", "10"], env=alone, check=True, capture_output=True, text=True)
    seconds = float(said.stdout.split()[-2])
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        (work / "exhibit.toml").write_text(exhibit())
        subprocess.run([folder / "vitrine", "design", "exhibit.toml", "-o", "build"], cwd=work, check=True, capture_output=True)
        films = np.stack([iio.imread(film) / 255.0 for film in sorted((work / "build" / "films").glob("*.png"))], 1)
        return films[..., :3].astype(np.float32), seconds


def matrix(angle):
    """Our operator, row of a picture x (film, column), by architecture's formula."""
    operator = np.zeros((PIXELS, FILMS, PIXELS), np.float32)
    for film in range(FILMS):
        z = ((FILMS - 1) / 2 - film) * PITCH_MM
        places = np.arange(PIXELS) + z * np.tan(np.radians(angle)) / PIXEL_MM
        lower = np.floor(places + 1e-9).astype(int)
        part = np.maximum(places - lower, 0)
        for offset, weight in ((0, 1 - part), (1, part)):
            inside = (lower + offset >= 0) & (lower + offset < PIXELS)
            operator[np.arange(PIXELS)[inside], film, (lower + offset)[inside]] += weight[inside]
    return operator.reshape(PIXELS, -1)


def geometry():
    volume = astra.create_vol_geom(FILMS, PIXELS, -WIDTH_MM / 2, WIDTH_MM / 2, -FILMS * PITCH_MM / 2, FILMS * PITCH_MM / 2)
    slopes = [np.tan(np.radians(angle)) for _, angle in VIEWS]
    rays = np.array([[-slope, -1.0, 0.0, 0.0, PIXEL_MM, 0.0] for slope in slopes])
    return volume, astra.create_proj_geom("parallel_vec", PIXELS, rays)


def fitted_error(shown, wanted):
    """Sums of the gain-fitted squared errors need all rows: returns what the gain is made of."""
    return (shown * wanted).sum(), (shown * shown).sum(), (wanted * wanted).sum(), wanted.size


def psnr(parts):
    product, square, wanted, count = np.sum(parts, axis=0)
    return -10 * np.log10((wanted - product**2 / square) / count)


def main():
    films, vitrine_seconds = vitrine(pathlib.Path(sys.argv[1]).resolve())
    patterns = [iio.imread(PHOTOS / f"{name}.jpg")[..., :3].astype(np.float32) / 255.0 for name, _ in VIEWS]
    operators = [matrix(angle) for _, angle in VIEWS]

    volume, rays = geometry()
    projector = astra.create_projector("linear", rays, volume)
    astra_matrix = astra.matrix.get(astra.projector.matrix(projector)).tocsr()
    # A ray is longer the more it slants; ASTRA 2.5 takes the length within a pixel from its width.
    lengths = [PIXEL_MM / np.cos(np.radians(angle)) for _, angle in VIEWS]
    worst = 0.0
    inner = slice(PIXELS // 4, -PIXELS // 4)
    for view, (operator, length) in enumerate(zip(operators, lengths)):
        theirs = astra_matrix[view * PIXELS:(view + 1) * PIXELS].toarray() / length
        worst = max(worst, np.linalg.norm((theirs - operator)[inner]) / np.linalg.norm(operator[inner]))
    print(f"operators differ by {worst:.1e} of their norm")
    assert worst < 3e-4

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
            sino = np.stack([BRIGHTNESS * FILMS * length * patterns[view][row, :, channel] for view, length in enumerate(lengths)])
            data, target = astra.data2d.create("-vol", volume, 0.0), astra.data2d.create("-sino", rays, sino)
            config = astra.astra_dict("SIRT")
            config.update(ProjectorId=projector, ReconstructionDataId=data, ProjectionDataId=target)
            config["option"] = {"MinConstraint": 0.0, "MaxConstraint": 1.0}
            states[row, channel] = (data, astra.algorithm.create(config))
    iterations, reached = 0, 0.0
    while reached < wanted and iterations < 5000:
        step = 10
        for data, algorithm in states.values():
            begin = time.perf_counter()
            astra.algorithm.run(algorithm, step)
            seconds += time.perf_counter() - begin
        iterations += step
        reached = quality({key: astra.data2d.get(data) for key, (data, _) in states.items()})
    whole = seconds * PIXELS / len(ROWS)
    print(f"Vitrine: {wanted:.2f} dB on these rows in {vitrine_seconds:.2f} s")
    print(f"ASTRA's SIRT: {reached:.2f} dB after {iterations} iterations, {whole:.1f} s for all rows")
    print(f"ratio: {whole / vitrine_seconds:.0f}")


if __name__ == "__main__":
    main()
