"""The device's table of the setup file: addresses, certificates, ports."""

from __future__ import annotations

import pytest
from support.ni_samples import ni_setup

from radargui.model.errors import SetupError
from radargui.model.setup import dump_setup, parse_setup


def test_a_certificate_is_for_a_device_server() -> None:
    text = dump_setup(ni_setup("lab-pc:31763", remote_certificate="server.pem"))
    assert parse_setup(text).daq.remote_certificate == "server.pem"
    with pytest.raises(SetupError, match=r"daq.remote_certificate is given, allowed: together with daq.remote"):
        parse_setup(text.replace('remote = "lab-pc:31763"\n', ""))
