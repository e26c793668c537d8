"""Encrypted connections to a device server, with the real gRPC and nidaqmx client."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.ni_samples import code_recording, ni_setup
from support.ni_server import serve
from support.ni_server.server import CERTIFICATES

from radargui.model.errors import DeviceError
from radargui.sources.ni.discovery import driver_version, find_devices
from radargui.sources.ni.driver import open_channel
from radargui.sources.ni.source import NiSource

AUTHORITY, STRANGER = str(CERTIFICATES / "authority.pem"), str(CERTIFICATES / "stranger.pem")


def refused(address: str, certificate: str | None) -> str:
    with pytest.raises(DeviceError) as caught:
        find_devices(address, certificate)
    assert caught.value.remedy
    return str(caught.value)


def test_samples_come_through_an_encrypted_connection_bit_for_bit() -> None:
    recording = code_recording(400)
    with serve(recording, certificate="server") as server:
        source = NiSource(ni_setup(server.address, remote_certificate=AUTHORITY))
        source.open()
        source.start()
        block = source.read()
        source.close()
        assert [device.name for device in find_devices(server.address, AUTHORITY)] == ["Dev1"]
        assert driver_version(server.address, AUTHORITY) == "24.8.0"
    assert block is not None
    np.testing.assert_array_equal(block.samples, recording.raw[:, :200])


def test_the_server_s_own_certificate_may_be_given_instead_of_its_authority_s(tmp_path: Path) -> None:
    chain = tmp_path / "both.pem"
    chain.write_bytes((CERTIFICATES / "server.pem").read_bytes() + (CERTIFICATES / "authority.pem").read_bytes())
    with serve(code_recording(10), certificate="server") as server:
        assert find_devices(server.address, str(chain))


def test_another_certificate_is_told() -> None:
    with serve(code_recording(10), certificate="server") as server:
        text = refused(server.address, STRANGER)
    assert f"server at {server.address} has another certificate than the one given" in text


def test_a_certificate_for_another_name_is_told() -> None:
    with serve(code_recording(10), certificate="other_name") as server:
        text = refused(server.address, AUTHORITY)
    assert "is for another name" in text
    assert "'127.0.0.1'" in text


def test_a_certificate_for_a_server_without_encryption_is_told() -> None:
    with serve(code_recording(10)) as server:
        text = refused(server.address, AUTHORITY)
    assert "does not answer encrypted" in text
    assert "Leave out daq.remote_certificate" in text


def test_a_server_with_encryption_asked_without_certificate_is_told() -> None:
    with serve(code_recording(10), certificate="server") as server, pytest.raises(DeviceError) as caught:
        open_channel(server.address, connect_s=0.5)
    text = str(caught.value)
    assert f"The NI gRPC device server at {server.address} answers only encrypted (TLS)." in text
    assert "--certificate" in text


def test_a_missing_file_or_one_without_certificate_is_told_before_anything_is_sent(tmp_path: Path) -> None:
    with serve(code_recording(10), certificate="server") as server:
        assert "absent.pem cannot be read: No such file" in refused(server.address, str(tmp_path / "absent.pem"))
        for content in (b"", b"\xff\x00", (CERTIFICATES / "server.key").read_bytes()):
            (tmp_path / "odd.pem").write_bytes(content)
            assert "holds no certificate in PEM form" in refused(server.address, str(tmp_path / "odd.pem"))
        assert "cannot be read" in refused(server.address, "a\0b")
        assert not server.calls
