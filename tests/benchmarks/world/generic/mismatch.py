"""Tracer-borne mismatch: generic (smooth in position) and physical (mirrors by image theory)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Field = Callable[[Array], Array]


def smooth_field(rng: np.random.Generator, size: float, shortest_m: float = 0.25) -> Field:
    """Return a smooth function of position: three long plane waves and a quadric, rms about `size`."""
    direction = rng.standard_normal((3, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    wave = direction * (2.0 * np.pi / rng.uniform(shortest_m, 0.7, 3))[:, None]
    phase = rng.uniform(0.0, 2.0 * np.pi, 3)
    weight = rng.standard_normal(3)
    linear, bend = rng.standard_normal(3) / 0.3, rng.standard_normal((3, 3)) / 0.09

    def value(p: Array) -> Array:
        waves = weight @ np.sin(wave @ p + phase[:, None])
        polynomial = 0.3 * (linear @ p + np.einsum("in,ij,jn->n", p, bend, p))
        return size / 1.5 * (waves + polynomial)

    return value


@dataclass(frozen=True)
class Plane:
    """A mirror n.x = d with the complex reflection it gives on the way to the tracer and to each receiver."""

    normal: Array
    distance_m: float
    forward: complex
    backward: Complex


def draw_floor(rng: np.random.Generator, rho: float, lowest_m: float, n_receivers: int) -> Plane:
    """A floor 5-25 mm below the lowest place of the centre, tilted up to about a degree."""
    normal = np.array([*(0.01 * rng.standard_normal(2)), 1.0])
    normal /= np.linalg.norm(normal)
    turn = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, n_receivers + 1))
    size = rho * rng.uniform(0.8, 1.2, n_receivers + 1)
    return Plane(normal, lowest_m - rng.uniform(0.005, 0.025), complex(size[0] * turn[0]), size[1:] * turn[1:])


def draw_wall(rng: np.random.Generator, rho: float, n_receivers: int) -> Plane:
    """A vertical wall 10-18 cm from the axis."""
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    normal = -np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    turn = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, n_receivers + 1))
    size = rho * rng.uniform(0.7, 1.3, n_receivers + 1)
    return Plane(normal, -rng.uniform(0.10, 0.18), complex(size[0] * turn[0]), size[1:] * turn[1:])


def mirrored(point: Array, plane: Plane) -> Array:
    """Return the image of a point in a plane."""
    return point - 2.0 * (plane.normal @ point - plane.distance_m) * plane.normal


def reflections(p: Array, tx: Array, rx: Array, receiver: int, planes: tuple[Plane, ...], wavenumber: float) -> Complex:
    """Return the ratio of the field at the receiver with mirrors to the field without: 1 + sum of images."""

    def ratio(antenna: Array, plane: Plane) -> Complex:
        direct = np.linalg.norm(p - antenna[:, None], axis=0)
        image = np.linalg.norm(p - mirrored(antenna, plane)[:, None], axis=0)
        return direct / image * np.exp(1j * wavenumber * (image - direct))

    forward = sum((plane.forward * ratio(tx, plane) for plane in planes), np.ones(p.shape[1], complex))
    backward = sum((plane.backward[receiver] * ratio(rx, plane) for plane in planes), np.ones(p.shape[1], complex))
    return forward * backward
