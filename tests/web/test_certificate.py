"""The page over HTTPS: the certificate of this machine, and the user's own."""

import datetime as dt
import os
import socket
import ssl
import stat
import sys
import time
from urllib.parse import urlsplit

import httpx
import pytest
from cryptography import x509
from makeup_video.pipeline import InputError, InstallError, OutputError
from makeup_video.web import certificate, connection, server
from makeup_video.web.certificate import lan_address, load_context, own_certificate
from makeup_video.web.connection import WebSocketsSansIOProtocol
from shows import RED, Page, StandIn, serving


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    return own_certificate("127.0.0.1", tmp_path_factory.mktemp("own"))


@pytest.fixture
def trusting(own):
    return ssl.create_default_context(cafile=own)


def read(file):
    return x509.load_pem_x509_certificate(file.read_bytes())


def test_the_certificate_is_made_once_for_its_user_alone(tmp_path):
    folder = tmp_path / "new" / "folder"
    file = own_certificate("127.0.0.1", folder)
    made = file.read_bytes()
    assert own_certificate("127.0.0.1", folder) == file and file.read_bytes() == made
    assert list(folder.iterdir()) == [file]
    if os.name == "posix":
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_the_certificate_names_what_browsers_may_ask_for(tmp_path):
    own_names = read(own_certificate("pc.example", tmp_path)).extensions.get_extension_for_class(
        x509.SubjectAlternativeName
    )
    names = own_names.value.get_values_for_type(x509.DNSName)
    addresses = {str(one) for one in own_names.value.get_values_for_type(x509.IPAddress)}
    assert set(names) == {"localhost", "pc.example"}  # the names that same_origin.py accepts
    assert {"127.0.0.1", "::1", *filter(None, [lan_address()])} <= addresses
    assert "0.0.0.0" not in addresses


def spoil(file, how):
    if how == "is readable by others":
        file.chmod(0o644)
    elif how == "is damaged":
        file.write_bytes(file.read_bytes()[:300])
    elif how == "is of another key":
        key, end = file.read_bytes().partition(b"-----BEGIN CERTIFICATE")[::2]
        other = own_certificate("127.0.0.1", file.parent / "other").read_bytes()
        file.write_bytes(key + b"-----BEGIN CERTIFICATE" + other.partition(b"BEGIN CERTIFICATE")[2])
        assert end not in file.read_bytes()


@pytest.mark.parametrize("how", ["is readable by others", "is damaged", "is of another key"])
def test_a_certificate_is_made_anew_when_it(how, tmp_path):
    if how == "is readable by others" and os.name != "posix":
        pytest.skip("modes of files are POSIX's")
    file = own_certificate("127.0.0.1", tmp_path)
    before = read(file)
    spoil(file, how)
    own_certificate("127.0.0.1", tmp_path)
    assert read(file) != before
    load_context(file)


@pytest.mark.parametrize("days", [0, 391, -2])
def test_a_certificate_is_renewed_before_it_ends(days, tmp_path, monkeypatch):
    file = own_certificate("127.0.0.1", tmp_path)
    before = read(file)
    later = dt.datetime.now(dt.UTC) + dt.timedelta(days=days)
    monkeypatch.setattr(certificate, "_now", lambda: later)
    own_certificate("127.0.0.1", tmp_path)
    assert (read(file) == before) is (days == 0)


def test_a_new_host_gets_a_new_certificate(tmp_path):
    file = own_certificate("127.0.0.1", tmp_path)
    before = read(file)
    own_certificate("pc.example", tmp_path)
    assert read(file) != before


def test_a_folder_that_cannot_be_written_names_a_way_out(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"cannot be written.*certificate"):
        own_certificate("127.0.0.1", tmp_path / "file")


def test_a_key_that_cannot_be_read_is_named(own, tmp_path, monkeypatch):
    key = tmp_path / "key.pem"
    key.touch()

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")  # ssl leaves out the file's name

    monkeypatch.setattr(ssl.SSLContext, "load_cert_chain", refuse)
    with pytest.raises(InputError, match=r"key\.pem cannot be read: .*; give yourself permission"):
        load_context(own, str(key))


def test_without_cryptography_the_error_names_the_command(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "cryptography", None)
    with pytest.raises(InstallError, match=r"pip install 'makeup-video\[https\]'"):
        own_certificate("127.0.0.1", tmp_path)


@pytest.mark.parametrize("system", ["linux", "darwin", "win32"])
def test_the_certificate_lies_in_the_user_s_data_folder(system, tmp_path, monkeypatch):
    monkeypatch.setattr(certificate.sys, "platform", system)
    for name in ("HOME", "XDG_DATA_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path))
    file = own_certificate("127.0.0.1")
    assert file.is_relative_to(tmp_path) and file.parent.name == "makeup-video"


def test_two_files_of_the_user_are_read_and_faults_named(own, tmp_path):
    key, rest = own.read_bytes().partition(b"-----BEGIN CERTIFICATE")[::2]
    (tmp_path / "key.pem").write_bytes(key)
    (tmp_path / "cert.pem").write_bytes(b"-----BEGIN CERTIFICATE" + rest)
    load_context(tmp_path / "cert.pem", str(tmp_path / "key.pem"))
    with pytest.raises(InputError, match=r"cert\.pem and the key in it.*PEM"):
        load_context(tmp_path / "cert.pem")
    with pytest.raises(InputError, match=r"nothing\.pem is not a file"):
        load_context(tmp_path / "cert.pem", str(tmp_path / "nothing.pem"))


def test_a_key_with_a_password_is_refused_without_a_question(own, tmp_path):
    from cryptography.hazmat.primitives import serialization as s

    key = s.load_pem_private_key(own.read_bytes(), None)
    locked = key.private_bytes(
        s.Encoding.PEM, s.PrivateFormat.PKCS8, s.BestAvailableEncryption(b"x")
    )
    (tmp_path / "key.pem").write_bytes(locked)
    with pytest.raises(InputError, match="without a password"):
        load_context(own, str(tmp_path / "key.pem"))


# -- the server


@pytest.fixture
def served(own):
    show = StandIn()
    with serving(show, tls=load_context(own)) as url:
        yield show, url


def test_page_and_web_socket_work_over_https(served, trusting):
    show, url = served
    assert url.startswith("https://127.0.0.1:")
    answer = httpx.get(url, verify=trusting)
    assert answer.status_code == 200 and "makeup-video" in answer.text
    with Page(url, tls=trusting) as page:
        show.show(7, jpeg=bytes(300_000))  # more than any buffer on the way
        assert page.picture()[0] == 7
        show.show(8)
        assert page.picture()[0] == 8
        page.send("look", look=RED.to_dict(), n=1)


@pytest.mark.parametrize("scheme", ["http", "ftp"])
def test_only_the_page_s_own_scheme_is_its_origin(served, trusting, scheme):
    _, url = served
    other = url.replace("https", scheme)
    answer = httpx.post(f"{url}/photo?session=stand-in", headers={"origin": other}, verify=trusting)
    assert answer.status_code == 403


def test_a_peer_that_never_shakes_hands_is_cut_off(own, monkeypatch):
    monkeypatch.setattr(server, "_HANDSHAKE_SECONDS", 0.3)
    with serving(StandIn(), tls=load_context(own)) as url:
        parts = urlsplit(url)
        with socket.create_connection((parts.hostname, parts.port), timeout=20) as raw:
            assert raw.recv(1) == b""


def test_a_flood_over_https_is_read_in_small_parts(served, trusting, monkeypatch):
    _, url = served
    sizes = []
    received = WebSocketsSansIOProtocol.data_received

    def noting(self, data):
        sizes.append(len(data))
        received(self, data)

    monkeypatch.setattr(WebSocketsSansIOProtocol, "data_received", noting)
    with Page(url, tls=trusting) as page:
        for n in range(300):
            page.send("look", look=RED.to_dict(), n=n)
        page.send("nothing")
        page.message("error")
    assert len(sizes) > 20 and max(sizes) <= connection._READ_BYTES


def test_a_page_that_reads_nothing_holds_up_no_other(served, trusting):
    show, url = served
    with Page(url, tls=trusting), Page(url, tls=trusting) as page:
        for pts in range(20):
            show.show(pts, jpeg=bytes(500_000))
            assert page.picture()[0] == pts
            time.sleep(0.01)
