from radargui.api import (
    BounceTable as BounceTable,
    Result as Result,
    Run as Run,
    open_run as open_run,
    process as process,
    series as series,
)
from radargui.model.channel_quality import ChannelQuality as ChannelQuality
from radargui.model.errors import RadarGuiError as RadarGuiError
from radargui.model.recording import Recording as Recording
from radargui.model.result import Bounce as Bounce, FreeFall as FreeFall
from radargui.model.setup import Setup as Setup, read_setup as read_setup

__version__: str
__all__ = [
    "Bounce",
    "BounceTable",
    "ChannelQuality",
    "FreeFall",
    "RadarGuiError",
    "Recording",
    "Result",
    "Run",
    "Setup",
    "__version__",
    "open_run",
    "process",
    "read_setup",
    "series",
]
