"""What flights leave of the inputs of a setup: a covariance that stays one where they are known unequally well."""

from __future__ import annotations

import numpy as np

from radargui.restitution.setup_chi_square import SetupChiSquare


def test_a_posterior_has_a_root_where_rounding_parts_the_triangles_of_its_matrix() -> None:
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.standard_normal((24, 24)))[0]
    cost = turn @ np.diag(np.geomspace(1e-2, 1e10, 24)) @ turn.T
    # each element to 15 digits of the largest
    cost += 1e-5 * rng.standard_normal(cost.shape)
    none = np.zeros(24)
    chi_square = SetupChiSquare(0.0, 1.0, cost, none, np.ones(24), 9.81, none, 0.0)
    posterior = chi_square.posterior(np.zeros(24, dtype=np.bool_), none)
    np.testing.assert_array_equal(posterior, posterior.T)
    root = np.linalg.cholesky(posterior)
    np.testing.assert_allclose(root @ root.T, posterior, atol=1e-12)
    np.testing.assert_allclose(posterior, np.linalg.inv(cost + np.eye(24)), atol=1e-3)
