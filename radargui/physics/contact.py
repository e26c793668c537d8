"""How long an elastic sphere touches a plate (Hertz 1882; K. L. Johnson, Contact Mechanics, section 11.4)."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup

_COMPLIANCE_1_PA = {
    name: (1.0 - poisson**2) / young_pa
    for name, young_pa, poisson in (
        ("steel", 210e9, 0.30),
        ("glass", 70e9, 0.22),
        ("granite", 55e9, 0.25),
        ("acrylic", 3.2e9, 0.37),
        ("PMMA", 3.2e9, 0.37),
        ("PE", 0.9e9, 0.42),
        ("PTFE", 0.5e9, 0.46),
        # of the metals that spheres are made of aluminium is the softest
        ("metal", 70e9, 0.33),
    )
}
"""(1 - nu^2) / E: handbook values, which differ by a tenth for metals and glass and by a half for plastics."""


def contact_time_s(setup: Setup, speed_m_s: FloatArray) -> FloatArray | None:
    """Return how long impacts at speeds (n,) last, shape (n,); None where the setup does not say what meets.

    T = 2.87 (m^2 / (R E*^2 v))^(1/5), 1/E* the sum of both compliances.
    """
    tracer, floor = setup.tracer, setup.floor
    if floor.material is None or tracer.density_kg_m3 is None or tracer.refractive_index is not None:
        return None
    radius_m = 0.5 * tracer.diameter_m
    mass_kg = 4.0 / 3.0 * np.pi * radius_m**3 * tracer.density_kg_m3
    compliance = _COMPLIANCE_1_PA[tracer.material] + _COMPLIANCE_1_PA[floor.material]
    return np.asarray(2.87 * (mass_kg**2 * compliance**2 / (radius_m * speed_m_s)) ** 0.2)
