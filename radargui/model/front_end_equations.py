"""The front end's equations, the one place where I and Q are made from a complex signal Z and brought back to it.

    I = Re Z + c_I,   Q = g (sin eps Re Z + cos eps Im Z) + c_Q         (method 1; Heydemann 1981, eq. 3)

g is the gain ratio, eps the quadrature error. The offsets c are added and taken off by those who call, because what
stands beside Z differs from one correction to the next (constants, maps, splines).
"""

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray


def channels_of(
    z_of_i: ComplexArray, z_of_q: ComplexArray, gain_ratio: float, quadrature_error_rad: float
) -> FloatArray:
    """Return what the two channels show of Z, without offsets, shape (2, ...).

    Parameters
    ----------
    z_of_i, z_of_q
        Z when I is sampled and when Q is: a multiplexer takes them one after the other. Shape (...).
    gain_ratio
        g, amplitude of Q over amplitude of I.
    quadrature_error_rad
        eps, departure of Q from 90 degrees after I.
    """
    sine, cosine = np.sin(quadrature_error_rad), np.cos(quadrature_error_rad)
    return np.stack([z_of_i.real, gain_ratio * (sine * z_of_q.real + cosine * z_of_q.imag)])


def q_by_quadrature_error(z_of_q: ComplexArray, gain_ratio: float, quadrature_error_rad: float) -> FloatArray:
    """Return dQ / d eps = g (cos eps Re Z - sin eps Im Z), shape (...)."""
    sine, cosine = np.sin(quadrature_error_rad), np.cos(quadrature_error_rad)
    return np.asarray(gain_ratio * (cosine * z_of_q.real - sine * z_of_q.imag))


def point_of(i: FloatArray, q: FloatArray, gain_ratio: float, quadrature_error_rad: float) -> FloatArray:
    """Return X = Re Z and Y = Im Z of channels without offsets, the inverse of `channels_of`, shape (2, ...).

    X = I, Y = (Q / g - X sin eps) / cos eps.

    Parameters
    ----------
    i, q
        Offsets taken off, at the same instant, shape (...).
    gain_ratio, quadrature_error_rad
        As in `channels_of`.
    """
    # Q leans towards I by eps: its share of X is taken off before it is stretched back
    y = (q / gain_ratio - i * np.sin(quadrature_error_rad)) / np.cos(quadrature_error_rad)
    return np.stack([i, y])
