"""Motion of a standing base by millimetres, from the ranges of its lidar."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

MIN_COSINE = 0.25  # between a beam and the normal of its surface
MAX_NEIGHBOUR_M = 0.4  # between the points of neighbouring beams on one surface
MAX_BEND_M = 0.03  # of a point from the line between its neighbours
MIN_BEAMS = 30
OUTLIER_SIGMAS = 4.0


def small_motions(angles: FloatArray, reference: FloatArray, scans: FloatArray) -> FloatArray | None:
    """Return the motions (k, 3) of a sensor since a reference scan: x, y in [m] and heading in [rad].

    They are reference_T_sensor, in the sensor frame at the time of the reference. Each beam is assumed to
    meet the tangent of the surface at the point that it met before, so that only motion along the surface's
    normal changes its range. This is valid for motions of millimetres.

    Args:
        angles: (n,) directions of the beams in the sensor frame, ascending, in [rad], a full turn or less.
        reference: (n,) ranges of the reference, averaged over scans, in [m]; not finite for beams without a
            reading.
        scans: (k, n) ranges of the same beams in k scans, in [m].

    Returns:
        The motions; None if fewer than `MIN_BEAMS` beams meet smooth surfaces.
    """
    beams = np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.where(np.isfinite(reference), reference, np.nan)[:, None] * beams
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    along = after - before
    length = np.linalg.norm(along, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None]
        facing = (normals * beams).sum(axis=1)
        bend = np.abs(((points - before) * normals).sum(axis=1))
        smooth = (np.abs(facing) > MIN_COSINE) & (length < 2.0 * MAX_NEIGHBOUR_M) & (bend < MAX_BEND_M)
    if int(smooth.sum()) < MIN_BEAMS:
        return None
    aside = np.column_stack([-beams[:, 1], beams[:, 0]])
    # n.(d + r (b + turn b')) = n.b r_before, of a wall with the normal n and a beam b
    turning = -reference[smooth] * (normals * aside)[smooth].sum(axis=1)
    A = np.column_stack([-normals[smooth], turning]) / facing[smooth, None]
    return np.array([_solved(A, (scan - reference)[smooth]) for scan in scans])


def _solved(A: FloatArray, change: FloatArray) -> FloatArray:
    """Return the motion (3,) by least squares, without beams that meet something else."""
    usable = np.isfinite(change)
    middle = float(np.median(change[usable]))
    spread = 1.4826 * float(np.median(np.abs(change[usable] - middle)))
    usable[usable] &= np.abs(change[usable] - middle) <= OUTLIER_SIGMAS * max(spread, 1e-6)
    return np.asarray(np.linalg.lstsq(A[usable], change[usable], rcond=None)[0])


def drift(times: FloatArray, motions: FloatArray, references: int) -> FloatArray:
    """Return motions (k, 3) of a sensor that are smooth, fitted to noisy ones.

    They are quadratic in time, and zero at the time of the reference scan since which motion is measured. The
    noise of the reference scan shifts all motions by the same amount, which is estimated too.

    Args:
        times: (k,) times since the reference scan, ascending, in [s].
        motions: (k, 3) reference_T_sensor of single scans: x, y in [m] and heading in [rad].
        references: number of scans over which the reference scan was averaged.
    """
    scale = max(float(times[-1]), 1e-9)
    powers = np.column_stack([times / scale, (times / scale) ** 2, np.ones(len(times))])
    A = np.vstack([powers, [0.0, 0.0, np.sqrt(references)]])
    found = np.linalg.lstsq(A, np.vstack([motions, np.zeros(3)]), rcond=None)[0]
    return np.asarray(powers[:, :2] @ found[:2])
