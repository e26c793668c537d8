"""Tests of the digitisation: who tells the multiplexer skew."""

from __future__ import annotations

from radargui.model.daq import Daq
from radargui.model.recording import ChannelSkew, Digitisation, channel_skew, iq_names

SILENT = Digitisation(iq_names(1), 1000.0)


def test_skew_that_came_with_the_samples_goes_before_that_of_the_setup() -> None:
    known = Digitisation(iq_names(1), 1000.0, channel_skew_s=0.0)
    assert channel_skew(known, Daq(channel_skew_s=5e-6)) == ChannelSkew(0.0, "file")


def test_skew_of_the_setup_holds_where_the_samples_come_without_it() -> None:
    assert channel_skew(SILENT, Daq(channel_skew_s=5e-6)) == ChannelSkew(5e-6, "setup")
    assert channel_skew(SILENT, Daq(channel_skew_s=0.0)) == ChannelSkew(0.0, "setup")


def test_skew_that_nobody_tells_is_said_to_be_assumed() -> None:
    assert channel_skew(SILENT, Daq()) == ChannelSkew(0.0, "assumed 0")
