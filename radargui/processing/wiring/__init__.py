"""The wiring check: from what the channels did in each step to what is wrong with the wires, and the settings for it.

`response`: how hard each channel answers, which antenna it belongs to, which way the phase of a pair turns; `check`
joins them and says what is wrong.
"""

from radargui.processing.wiring.check import WiringFinding, WiringReport, check_wiring
from radargui.processing.wiring.response import WiringSamples

__all__ = ["WiringFinding", "WiringReport", "WiringSamples", "check_wiring"]
