"""The wiring check: from what the channels did in each step to what is wrong with the wires, and the settings for it.

`response`: how hard each channel answers; `owners`: which antenna each belongs to; `rotation`: which way the phase of a
pair turns; `check` joins them; `findings`: what is said about it.
"""

from radargui.processing.wiring.check import check_wiring
from radargui.processing.wiring.findings import WiringFinding, WiringReport
from radargui.processing.wiring.response import WiringSamples

__all__ = ["WiringFinding", "WiringReport", "WiringSamples", "check_wiring"]
