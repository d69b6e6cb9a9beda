"""Positions of falling grey steps across an edge, to a fraction of a pixel."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IndexArray

SAMPLE_POSITIONS_PX: FloatArray = np.arange(-5.0, 5.25, 0.5)
"""Positions (21,) of a profile's samples outwards from the assumed edge, negative inside, in [px]."""
_AT: FloatArray = np.arange(-2.4, 2.5, 0.2)
_WIDTHS: FloatArray = np.array([1.0, 1.2, 1.4, 1.7, 2.0, 2.4, 2.8, 3.2, 3.8, 4.4, 5.0, 6.0])
_BLURS: FloatArray = np.arange(0.65, 1.46, 0.05)
_USUAL = 6  # 0.95 px: a lens of 0.7 px, the area of a pixel, sampling twice
_BETTER, _BETTER_AWAY = 0.4, 0.25  # share of the squared residuals that a second step leaves at most
_LEAST_GAIN = 0.5  # of their mean [squared grey levels] by which it lowers them
_SHAPE = 0.012  # how well a step's shape is known, as a share of its height
_LEAST_FIRST = 0.12  # of two steps: its share of their height
_LEAST_AWAY = 1.5  # [px] from an edge to the next one that is nothing of its own


class Steps(NamedTuple):
    """Result of fitting a step, the first decrease of grey, to each of k grey profiles across edges."""

    at: FloatArray
    """Position (k,) of each step outwards from the assumed edge, in [px]."""
    drop: FloatArray
    """Height (k,) of each step in grey levels; 0 without a step."""
    model: FloatArray
    """Fitted grey levels (k, 21), 0 to 255, at `SAMPLE_POSITIONS_PX`."""


class _Models(NamedTuple):
    """n models a + b S(at) + c S(at + width), S a blurred step."""

    at: FloatArray
    width: FloatArray
    basis: FloatArray
    """Profiles (n, 3, 21) whose factors are a, b and c."""
    solve: FloatArray
    """(n, 3, 21): a, b, c are this times a profile."""


class _Fit(NamedTuple):
    at: FloatArray
    width: FloatArray
    weights: FloatArray
    """Factors a, b and c (k, 3) of the best model."""
    model: FloatArray
    left: FloatArray
    """(k,) mean squared residual; infinite where no model has a step down."""


def fit_steps(profiles: FloatArray, away: BoolArray, least: float) -> Steps:
    """Fit a step from bright to dark to grey profiles across edges; fit two steps if one fits too badly.

    One step fits too badly if noise and the shape of the blur do not explain its mean squared residual.

    There are two steps if the side face under an edge is seen as a strip of a few pixels, of a third shade.
    Such a strip looks like a wide blur, so the blur is estimated from edges whose side face is turned away
    from the camera.

    Args:
        profiles: (k, 21) grey levels, from 0 to 255, at `SAMPLE_POSITIONS_PX` across each of k edges.
        away: (k,) True for edges whose side face is turned away from the camera.
        least: smallest step, in grey levels.
    """
    levels = profiles.mean(axis=1, keepdims=True)
    centred = profiles - levels
    height = profiles[:, :3].mean(axis=1) - profiles[:, -3:].mean(axis=1)
    first = np.maximum(least, _LEAST_FIRST * height)
    left, weights = _residuals(_singles(), centred, first)
    blur = _blur(left[:, away])
    one = slice(blur * len(_AT), (blur + 1) * len(_AT))
    single = _best(_single(blur), left[one], weights[one])
    double = _best(_double(blur), *_residuals(_double(blur), centred, first))
    with np.errstate(invalid="ignore"):
        better = single.left - double.left > _LEAST_GAIN + (_SHAPE * height) ** 2
    better &= double.left < np.where(away, _BETTER_AWAY, _BETTER) * single.left
    better &= ~away | (double.width > _LEAST_AWAY)
    at, drop, left = (
        np.where(better, two, one)
        for one, two in (
            (single.at, double.at),
            (-single.weights[:, 1], -double.weights[:, 1]),
            (single.left, double.left),
        )
    )
    model = np.where(better[:, None], double.model, single.model) + levels
    return Steps(at, np.where(np.isfinite(left), drop, 0.0), model)


def _blur(left: FloatArray) -> int:
    """Return the index of the blur that fits edges of one step best, by the mean of all."""
    each = left.reshape(len(_BLURS), len(_AT), -1).min(axis=1)
    there = np.isfinite(each).all(axis=0)
    return round(float(each[:, there].argmin(axis=0).mean())) if there.any() else _USUAL


def _residuals(models: _Models, centred: FloatArray, least: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean squared residuals (n, k) and weights (n, 3, k) of all models."""
    shape = (-1, 3, len(centred))
    onto, weights = (
        (model.reshape(-1, len(SAMPLE_POSITIONS_PX)) @ centred.T).reshape(shape) for model in models[2:]
    )
    left = np.maximum((centred**2).sum(axis=1) - (weights * onto).sum(axis=1), 0.0) / len(SAMPLE_POSITIONS_PX)
    left[weights[:, 1] > -least] = np.inf
    return left, weights


def _best(models: _Models, left: FloatArray, weights: FloatArray) -> _Fit:
    best = left.argmin(axis=0)
    each = np.arange(left.shape[1])
    chosen = weights[best, :, each]
    model = np.matmul(chosen[:, None], models.basis[best])[:, 0]
    return _Fit(models.at[best] + _between(left, best), models.width[best], chosen, model, left[best, each])


def _between(left: FloatArray, best: IndexArray) -> FloatArray:
    """Return the offsets (k,), in [px], from the best position to the minimum of a parabola through it and
    its neighbours.
    """
    each = np.arange(left.shape[1])
    inner = (best % len(_AT) > 0) & (best % len(_AT) < len(_AT) - 1)
    before, after = (left[np.where(inner, best + d, best), each] for d in (-1, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        share = 0.5 * (before - after) / (before + after - 2 * left[best, each])
    return np.where(inner & np.isfinite(share), np.clip(share, -0.5, 0.5) * (_AT[1] - _AT[0]), 0.0)


@cache
def _singles() -> _Models:
    """Return the models of single steps, with all blurs at all positions."""
    return _Models(*(np.concatenate(parts) for parts in zip(*map(_single, range(len(_BLURS))), strict=True)))


@cache
def _single(blur: int) -> _Models:
    return _models(_AT, np.full(len(_AT), np.inf), float(_BLURS[blur]))


@cache
def _double(blur: int) -> _Models:
    """Return the models of double steps, with all widths at all positions."""
    width, at = (item.ravel() for item in np.meshgrid(_WIDTHS, _AT, indexing="ij"))
    return _models(at, width, float(_BLURS[blur]))


def _models(at: FloatArray, width: FloatArray, blur: float) -> _Models:
    first, second = (ndtr((SAMPLE_POSITIONS_PX - place[:, None]) / blur) for place in (at, at + width))
    basis = np.stack([np.ones_like(first), first, second], axis=1)
    return _Models(at, width, basis, np.linalg.pinv(basis, rcond=1e-5).swapaxes(1, 2))
