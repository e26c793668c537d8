"""The report's table of the receivers' quality."""

from __future__ import annotations

from dataclasses import replace

from support.results import drop_result

from radargui.report.content import Grid
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_section


def test_the_hardware_constants_stand_with_their_uncertainties_where_there_are_some() -> None:
    result = drop_result(rate_hz=1000.0)
    assert result.corrected is not None
    first, *others = result.corrected.channels
    known = replace(first, u_gain_ratio=0.0012, u_quadrature_error_deg=0.031)
    result = replace(result, corrected=replace(result.corrected, channels=(known, *others)))
    blocks = run_section(take_facts(result, "run-0001"), result.setup).blocks
    (grid,) = (one for one in blocks if isinstance(one, Grid) and one.header[0] == "receiver")
    gain, quadrature = grid.header.index("gain Q/I"), grid.header.index("quadrature / °")
    assert (grid.rows[0][gain], grid.rows[0][quadrature]) == ("0.9300 ± 0.0012", "5.700 ± 0.031")
    assert (grid.rows[1][gain], grid.rows[1][quadrature]) == ("0.9300", "5.700")
