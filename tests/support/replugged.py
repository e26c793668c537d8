"""A program that opens a device, sees it unplugged and plugged in again, and opens it once more."""

from __future__ import annotations

import sys
from pathlib import Path

from radargui.model.setup import read_setup
from radargui.sources.ni.discovery import find_devices
from radargui.sources.ni.source import NiSource


def opened(setup_path: str) -> None:
    source = NiSource(read_setup(Path(setup_path)))
    digitisation = source.open()
    assert source.device is not None
    print(source.device.max_rate_multi_hz, source.device.min_rate_hz, f"{digitisation.channel_skew_s:.3g}")
    source.close()


def main() -> None:
    find_devices()
    opened(sys.argv[1])
    Path(sys.argv[2]).touch()
    opened(sys.argv[1])
    print([device.max_rate_multi_hz for device in find_devices()])


if __name__ == "__main__":
    main()
