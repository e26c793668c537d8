"""The device's table of the setup file: addresses, certificates, ports."""

from __future__ import annotations

import pytest
from support.ni_samples import ni_setup

from radargui.model.errors import SetupError
from radargui.model.setup import dump_setup, parse_setup


@pytest.mark.parametrize("address", ["lab-pc:1", "lab-pc:31763", "10.0.0.7:65535", "[fe80::1]:31763"])
def test_an_address_has_a_host_and_a_port(address: str) -> None:
    assert parse_setup(dump_setup(ni_setup(address))).daq.remote == address


@pytest.mark.parametrize(
    "address", ["lab-pc", "lab-pc:0", "lab-pc:65536", "lab-pc:99999", "lab-pc:00080", ":80", "a b:80"]
)
def test_a_port_outside_of_1_to_65535_is_told_with_the_range(address: str) -> None:
    text = dump_setup(ni_setup("lab-pc:31763")).replace("lab-pc:31763", address)
    with pytest.raises(SetupError) as caught:
        parse_setup(text)
    assert f'daq.remote = "{address}", allowed: a text HOST:PORT with a port of 1 to 65535' in str(caught.value)


def test_a_certificate_is_for_a_device_server() -> None:
    text = dump_setup(ni_setup("lab-pc:31763", remote_certificate="server.pem"))
    assert parse_setup(text).daq.remote_certificate == "server.pem"
    with pytest.raises(SetupError, match=r"daq.remote_certificate is given, allowed: together with daq.remote"):
        parse_setup(text.replace('remote = "lab-pc:31763"\n', ""))
