"""Description of a map in words."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.mapping.map_building import BuiltMap
from handcart.robotics.navigation.mapping.odometry_agreement import disagreement_in_words
from handcart.robotics.navigation.mapping.scan_log import ScanLog

from .map_files import agreement_of, position_sigmas

MANY_UNMATCHED = 0.1
"""Share of motions without a match from which the map is doubtful."""


def in_words(log: ScanLog, built: BuiltMap) -> str:
    """Return the summary of a map as text: scans, loop closures with their fit, uncertainty."""
    duration = log.times[-1] - log.times[0]
    lines = [
        f"{len(log.times)} scans over {log.distance:.1f} m in {duration:.0f} s; {len(built.rows)} keyframes",
        *_loop_lines(built),
        *_unmatched_lines(built),
        *disagreement_in_words(agreement_of(log, built)),
    ]
    sigmas = position_sigmas(built)
    lines.append(
        f"position uncertainty relative to the start (1 sigma): median {100 * np.median(sigmas):.1f} cm, "
        f"at most {100 * sigmas.max():.1f} cm"
    )
    return "\n".join(lines)


def _loop_lines(built: BuiltMap) -> list[str]:
    rejected = ", ".join(f"{count} {reason}" for reason, count in built.rejected.most_common())
    beside = f"; rejected {built.rejected.total()}: {rejected}" if rejected else ""
    if not built.accepted:
        return [
            f"no loop closure found{beside}",
            "  errors of the motion add up along the way; drive through a place twice to correct them",
        ]
    matches = [loop.match for loop in built.accepted if loop.match is not None]
    inliers, sigmas = ([getattr(match, name) for match in matches] for name in ("inliers", "sigma"))
    return [
        f"loop closures: {len(built.accepted)} accepted{beside}",
        f"  they explain {100 * np.median(inliers):.0f} % of the points with residuals of "
        f"{1000 * np.median(sigmas):.0f} mm (medians), agree with each other within "
        f"{np.sqrt(np.median(built.chi2)):.1f} sigma (95 %: {np.sqrt(np.quantile(built.chi2, 0.95)):.1f}), "
        f"and moved the way by up to {built.shift:.2f} m",
    ]


def _unmatched_lines(built: BuiltMap) -> list[str]:
    motions = max(1, len(built.rows) - 1)
    if not built.blind:
        return []
    words = f"{built.blind} of {motions} motions are known from odometry alone: their scans do not fit"
    if built.blind > MANY_UNMATCHED * motions:
        words += "; the map is doubtful: check angles, mounting and clock of the lidar"
    return [words]
