"""Result of a replay as text and numbers."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import numpy as np

from .replay import Replayed

MAX_SHOWN_FIXES = 12  # rejected fixes listed one by one


def figures(replayed: Replayed) -> dict[str, Any]:
    """Return the metrics of a localizer that processed a recorded log, by name: fixes, uncertainty and
    errors.
    """
    claimed = np.sqrt(np.trace(replayed.covariances[:, :2, :2], axis1=1, axis2=2))
    refused = [fix for fix in replayed.fixes if not fix.believed]
    found: dict[str, Any] = {
        "seconds": round(float(replayed.times[-1] - replayed.times[0]), 1),
        "fixes": len(replayed.fixes),
        "refused": [{"time_s": fix.time, "why": fix.why} for fix in refused],
        "ranges": replayed.ranges[0],
        "ranges_refused": replayed.ranges[1],
        "heading_known_after_s": _known_after(replayed),
        "claimed_m_median": round(float(np.median(claimed)), 3),
        "claimed_m_last": round(float(claimed[-1]), 3),
    }
    sure = replayed.known & np.isfinite(replayed.truth[:, :2]).all(axis=1)
    if sure.any():
        away = replayed.errors[sure]
        lengths = np.hypot(away[:, 0], away[:, 1])
        inverse = np.linalg.inv(replayed.covariances[sure][:, :2, :2])
        squares = np.einsum("ni,nij,nj->n", away[:, :2], inverse, away[:, :2])
        found |= {
            "error_m_rms": round(float(np.sqrt(np.mean(lengths**2))), 3),
            "error_m_r95": round(float(np.quantile(lengths, 0.95)), 3),
            "error_m_max": round(float(lengths.max()), 3),
            "nees": round(float(squares.mean()), 2),
        }
        turned = np.abs(away[:, 2][np.isfinite(away[:, 2])])
        if len(turned):
            found["error_deg_rms"] = round(math.degrees(float(np.sqrt(np.mean(turned**2)))), 2)
    return found


def in_words(replayed: Replayed) -> str:
    """Return the result of a localizer's replay of a log as text."""
    found = figures(replayed)
    refused = [fix for fix in replayed.fixes if not fix.believed]
    lines = [
        f"{found['seconds']:.0f} s, {_heard(replayed)}",
        _of_heading(found["heading_known_after_s"]),
        f"claimed: {found['claimed_m_median']:.2f} m in the median, "
        f"{found['claimed_m_last']:.2f} m in the end",
    ]
    if "error_m_rms" in found:
        lines.append(
            f"against the reference: {found['error_m_rms']:.2f} m root mean square, 95 % within "
            f"{found['error_m_r95']:.2f} m, at most {found['error_m_max']:.2f} m; "
            f"squared errors are {found['nees']:.1f} claimed variances (2 where claims are true)"
        )
    begun = float(replayed.times[0])
    lines += [f"  refused after {fix.time - begun:.1f} s: {fix.why}" for fix in refused[:MAX_SHOWN_FIXES]]
    if len(refused) > MAX_SHOWN_FIXES:
        kinds = Counter(_kind(fix.why) for fix in refused[MAX_SHOWN_FIXES:])
        more = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
        lines.append(f"  and {len(refused) - MAX_SHOWN_FIXES} more: {more}")
    return "\n".join(lines)


def _heard(replayed: Replayed) -> str:
    """Return the numbers of fixes and ranges, and of those that were rejected, as text."""
    refused = sum(not fix.believed for fix in replayed.fixes)
    said = [f"{len(replayed.fixes)} fixes, {refused} of them refused"] if replayed.fixes else []
    if replayed.ranges[0]:
        said.append(f"{replayed.ranges[0]} ranges, {replayed.ranges[1]} of them refused")
    return "; ".join(said) or "neither fixes nor ranges"


def _kind(why: str) -> str:
    """Return the kind of a rejection, by its reason without the numbers."""
    for start, kind in (
        ("fixes before", "after others that were off"),
        ("the last", "off with those before"),
        ("jumps", "that jump"),
    ):
        if why.startswith(start):
            return kind
    return "off alone"


def _known_after(replayed: Replayed) -> float | None:
    """Return the time in [s] from the start until the heading is known; None if it never is."""
    if not replayed.known.any():
        return None
    return round(float(replayed.times[int(np.argmax(replayed.known))] - replayed.times[0]), 1)


def _of_heading(seconds: float | None) -> str:
    if seconds is None:
        return "which way it headed is never known: it needs fixes over some metres of way"
    return (
        "the heading is known from the beginning"
        if seconds == 0.0
        else f"the heading is known after {seconds} s"
    )
