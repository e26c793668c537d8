"""How the edges of a plate change what comes over the floor at the nodes of bins, and its slopes (method 1)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.parameters import Layout
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.physics.edges import ACROSS, ANTENNA, ASIDE, AZIMUTH, HEIGHT, MIDDLE, N_EDGES, SIDES, OverPlate, Rectangle
from radargui.physics.mirrors import MirrorPlane


@dataclass(frozen=True, slots=True)
class Edges:
    """Ways of transmitter and receiver over a plate; of several receivers all shapes begin with their number.

    Attributes
    ----------
    over
        The ways, of both ends: its shapes begin with 2.
    plane, unknown
        The plate's, and its two tilts and shift.
    azimuth_rad, sides, middle_m
        Of the first side; unit vectors along both, shape (2, 3); of the plate's middle, on its surface, shape (3,).
    antenna_m
        Places of both ends, shape (2, 3).
    place_m
        Of the sphere at the nodes, shape (3, 2 n_bins), those before the bins' middles first.
    """

    over: OverPlate
    plane: MirrorPlane
    unknown: FloatArray
    azimuth_rad: float
    sides: FloatArray
    middle_m: FloatArray
    antenna_m: FloatArray
    place_m: FloatArray

    def value(self) -> ComplexArray:
        """Return what the waves are multiplied with, shape (2, 2 nodes, n_bins)."""
        return _at_nodes(self.over.value())

    def of(self, receiver: int) -> Edges:
        """Return those of one receiver of several."""
        lengths = ("height_m", "antenna_m", "across_m", "aside_m", "power")
        over = replace(self.over, **{name: getattr(self.over, name)[receiver] for name in lengths})
        return replace(self, over=over, antenna_m=self.antenna_m[receiver], place_m=self.place_m[receiver])

    def slopes(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return the slopes of the logarithms: by the edges' unknowns, by the plane's and by the sphere's place.

        Shapes (2, 5, 2 nodes, n_bins), (2, 3, 2 nodes, n_bins) and (2, 3, 2 nodes, n_bins).
        """
        by_half, by_length = self.over.slopes()
        by_across, by_aside = by_length[..., ACROSS, :], by_length[..., ASIDE, :]
        # where the sides turn one way, places turn the other
        by_turn = _crossed(by_across, self.over.across_m) + _crossed(by_aside, self.over.aside_m)
        normal, along = self.plane.turned_normal(self.unknown), self.sides[:, :, None]
        aside = np.array([np.cos(self.azimuth_rad), np.sin(self.azimuth_rad), 0.0])
        leans = float(normal @ aside)
        by_edges = np.empty((*by_half.shape[:-2], N_EDGES, by_half.shape[-1]), complex)
        by_edges[..., SIDES, :] = by_half
        by_edges[..., AZIMUTH, :] = by_turn * normal[2] / (1.0 - leans**2)
        # the middle stays in the plane
        middle = np.array([[1.0, 0.0, -normal[0] / normal[2]], [0.0, 1.0, -normal[1] / normal[2]]])
        by_edges[..., MIDDLE, :] = -((self.sides @ middle.T)[:, :, None] * by_aside[..., None, :]).sum(axis=-3)
        by_place = ((by_across + by_aside)[..., None, :] * along).sum(axis=-3)
        by_place += by_length[..., HEIGHT, None, :] * normal[:, None]
        by_sphere = self.plane.height_slope(self.place_m, self.unknown)[..., None, :, :]
        by_antenna = self.plane.height_slope(np.swapaxes(self.antenna_m, -1, -2), self.unknown)
        by_antenna = np.swapaxes(by_antenna, -1, -2)[..., None]
        by_plane = by_length[..., HEIGHT, None, :] * by_sphere + by_length[..., ANTENNA, None, :] * by_antenna
        turn = self.plane.normal_slope(self.unknown)
        foot_m = self.plane.shifted_foot(self.unknown)
        # how far the middle rises where the plane leans, and with the plane
        rises = np.append(-turn @ (self.middle_m - foot_m), float(normal @ self.plane.normal)) / normal[2]
        by_plane -= rises[:, None] * (by_aside * self.sides[:, 2, None]).sum(axis=-2)[..., None, :]
        # the sides lean with it: what lies high moves along them
        climb = by_across * (self.over.height_m - self.over.antenna_m)[..., None, :]
        climb = climb + by_aside * self.over.height_m[..., None, :]
        by_plane[..., :2, :] -= ((self.sides @ turn.T)[:, :, None] * climb[..., None, :]).sum(axis=-3)
        by_plane[..., :2, :] -= (turn @ self.sides[1] * leans / (1.0 - leans**2))[:, None] * by_turn[..., None, :]
        return _at_nodes(by_edges), _at_nodes(by_plane), _at_nodes(by_place)


def edges_at(
    node_m: FloatArray,
    ends_m: FloatArray,
    theta: FloatArray,
    layout: Layout,
    planes: tuple[MirrorPlane, ...],
    fields: FloatArray | None,
    wavenumber: float,
) -> Edges | None:
    """Return the ways over the floor's plate at the nodes; None where no edges are unknowns.

    Parameters
    ----------
    node_m
        Positions at the nodes, (..., 3, 2 channels, 2 nodes, n_bins).
    ends_m
        Places of transmitter and receiver, (..., 2, 3).
    theta, layout, planes
        Global parameters, what they mean, the mirrors; the first is the floor.
    fields
        Directions of the fields of transmitter and receiver, (..., 2, 3); None where nobody knows them.
    wavenumber
        In 1/m.
    """
    values = theta[layout.edges]
    if not values.size:
        return None
    # both channels at once: between their samples the sphere moves by micrometres
    place = node_m.mean(axis=-3).reshape(*node_m.shape[:-3], -1)
    plane, unknown = planes[0], layout.plane_unknowns(theta)[0]
    normal, azimuth_rad = plane.turned_normal(unknown), float(values[AZIMUTH])
    plate = Rectangle.of(values, normal, plane.shifted_foot(unknown))
    height, antenna = plane.height(place, unknown), plane.height(np.swapaxes(ends_m, -1, -2), unknown)[..., None]
    over = plate.over(place, height, ends_m, antenna, fields, wavenumber)
    return Edges(over, plane, unknown, azimuth_rad, plate.sides, plate.middle_m, ends_m, place)


def _crossed(slopes: ComplexArray, lengths: FloatArray) -> ComplexArray:
    """Return what turns lengths along both sides, (..., 2, n), changes by these slopes, shape (..., n)."""
    return np.asarray(slopes[..., 0, :] * lengths[..., 1, :] - slopes[..., 1, :] * lengths[..., 0, :])


def _at_nodes(values: ComplexArray) -> ComplexArray:
    """Return values (..., 2 n_bins) as (..., 2 nodes, n_bins)."""
    return values.reshape(*values.shape[:-1], 2, -1)
