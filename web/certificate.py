"""The certificate of the page over HTTPS: the user's own, or one that this machine makes once.

Browsers let a page use H.264, a camera and more only over HTTPS, or on the machine itself. They
do not trust a certificate that a machine made for itself, and warn about it once. The traffic is
encrypted all the same.
"""

import contextlib
import datetime as dt
import os
import socket
import ssl
import sys
from ipaddress import IPv4Address, IPv6Address, ip_address
from pathlib import Path
from typing import TYPE_CHECKING

from makeup_video.pipeline.errors import InputError, InstallError, OutputError, UsageError, option
from makeup_video.pipeline.files.disk_errors import unreadable
from makeup_video.web.same_origin import is_name

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

Address = IPv4Address | IPv6Address
_VALID = dt.timedelta(days=397)  # the longest time that all browsers accept
_RENEWED = dt.timedelta(days=7)  # the certificate is renewed so long before it ends
_EARLIER = dt.timedelta(days=1)  # it is valid from a day ago, for machines whose clocks are behind
_NAME = "makeup-video"
_FILE = "page-certificate.pem"  # holds the key, too, so that both always belong together
_ANYWHERE = "192.0.2.1"  # an address that RFC 5737 reserves for documentation


def load_context(certificate: str | os.PathLike[str], key: str | None = None) -> ssl.SSLContext:
    """Read a certificate with its chain, and its key, from PEM files.

    key: None if the file `certificate` holds the key, too. Raises InputError with one line.
    """
    for name in (certificate, key):
        if name is not None and not Path(name).is_file():
            raise InputError(f"{name} is not a file: give a certificate and its key as PEM files")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certificate, key, password=_no_password)
    except (ssl.SSLError, ValueError) as error:
        raise InputError(
            f"{certificate} and {key or 'the key in it'} are not a certificate and its key: give "
            f"PEM files that belong together, the key without a password"
        ) from error
    except OSError as error:
        files = certificate if key is None else f"{certificate} or {key}"  # ssl does not say which
        raise InputError(unreadable(files, error)) from error
    return context


def _no_password() -> str:
    """Refuse a key with a password; without this function OpenSSL would ask on the terminal."""
    raise ValueError("the key has a password")


def own_certificate(host: str, folder: Path | None = None) -> Path:
    """Return the file of this machine's certificate, which is made anew if it is missing or old.

    host: as given to --host; the certificate names this host.  folder: where the file is kept;
    default: the user's folder for data. Only the user can read the file. Raises InstallError
    without `cryptography`, OutputError when the file cannot be written.
    """
    try:
        import cryptography  # noqa: F401
    except ImportError as error:
        raise InstallError(
            f"{option('https')} needs cryptography to make a certificate: run pip install "
            f"'makeup-video[https]', or give {option('certificate')} and {option('key')}"
        ) from error
    folder = folder or _data_folder()
    file = folder / _FILE
    names, addresses = _names(host)
    if not _is_good(file, names, addresses):
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            _write_private(file, _made(names, addresses))
        except OSError as error:
            raise OutputError(
                f"{file} cannot be written: {error.strerror}; give {option('certificate')} and "
                f"{option('key')}"
            ) from error
    return file


def lan_address() -> str | None:
    """The address by which other machines most likely reach this one; None without a network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as unused:
        try:
            unused.connect((_ANYWHERE, 9))  # only chooses the network to use; nothing is sent
            address: str = unused.getsockname()[0]
        except OSError:
            return None
    return None if ip_address(address).is_loopback else address


def _data_folder() -> Path:
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = str(Path.home() / "Library" / "Application Support")
    else:
        base = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    if not Path(base).is_absolute():  # the user has no home folder
        raise UsageError(
            f"there is no folder to keep a certificate in: give {option('certificate')} and "
            f"{option('key')}"
        )
    return Path(base) / _NAME


def _names(host: str) -> tuple[set[str], set[Address]]:
    """The names and addresses by which browsers may ask for the page; see same_origin.py."""
    names = {"localhost"}
    addresses = {ip_address("127.0.0.1"), ip_address("::1")}
    for one in filter(None, (host.lower(), lan_address())):
        try:
            addresses.add(ip_address(one.partition("%")[0]))  # without the scope of an IPv6 address
        except ValueError:
            if is_name(one):  # "*" and "0" are not names
                names.add(one.removesuffix("."))
    addresses -= {ip_address("0.0.0.0"), ip_address("::")}
    return {name for name in names if name.isascii()}, addresses


def _is_good(file: Path, names: set[str], addresses: set[Address]) -> bool:
    """Whether the file is private, and its certificate names all of these and stays valid."""
    from cryptography import x509

    try:
        if os.name == "posix" and file.stat().st_mode & 0o077:
            return False
        load_context(file)
        certificate = x509.load_pem_x509_certificate(file.read_bytes())
        known = _alternatives(certificate)
    except (OSError, ValueError, x509.ExtensionNotFound):
        return False
    now = _now()
    begins, ends = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    return begins <= now < ends - _RENEWED and known >= {*names, *addresses}


def _alternatives(certificate: "Certificate") -> set[str | Address]:
    from cryptography import x509

    san = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    known: set[str | Address] = set(san.get_values_for_type(x509.DNSName))
    known.update(
        one
        for one in san.get_values_for_type(x509.IPAddress)
        if isinstance(one, IPv4Address | IPv6Address)
    )
    return known


def _made(names: set[str], addresses: set[Address]) -> bytes:
    """A new key and its self-signed certificate, as PEM."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

    key = ec.generate_private_key(ec.SECP256R1())
    itself = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, _NAME)])
    now = _now()
    alternatives: list[x509.GeneralName] = [x509.DNSName(name) for name in sorted(names)]
    alternatives += [x509.IPAddress(address) for address in sorted(addresses, key=str)]
    certificate = (
        x509.CertificateBuilder()
        .subject_name(itself)
        .issuer_name(itself)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - _EARLIER)
        .not_valid_after(now - _EARLIER + _VALID)
        .add_extension(x509.SubjectAlternativeName(alternatives), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .sign(key, hashes.SHA256())
    )
    private = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    return private + certificate.public_bytes(serialization.Encoding.PEM)


def _now() -> dt.datetime:
    return dt.datetime.now(dt.UTC)


def _write_private(file: Path, data: bytes) -> None:
    """Write a file that only the user can read. Another run, which may be reading, never sees half
    a file: the new file replaces the old one in one step."""
    part = file.with_name(f"{file.name}.{os.getpid()}.part")
    with contextlib.suppress(FileNotFoundError):
        part.unlink()
    with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as out:
        out.write(data)
    part.replace(file)
