"""CURVE keys: authenticate clients and server over TCP.

A server's key directory::

    server.key            its public key: every client gets a copy
    server.key_secret     its secret key: stays here
    clients/NAME.key      public keys of the clients it lets in
    NAME.key_secret       a client's pair, to be moved to the client
"""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, NamedTuple

import zmq
from zmq.auth import create_certificates, load_certificate
from zmq.auth.thread import ThreadAuthenticator

from rfms_can.errors import LinkError

SERVER: Final = "server"
CLIENTS: Final = "clients"
PUBLIC: Final = ".key"
SECRET: Final = ".key_secret"
DOMAIN: Final = b"rfms"
"""ZAP domain: connections that require a key."""

_CLIENT_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")


class ClientKeys(NamedTuple):
    """Keys of a client: its own pair, and the server's public key (Z85)."""

    public: bytes
    secret: bytes
    server: bytes

    @classmethod
    def load(cls, secret_file: Path, server_file: Path) -> "ClientKeys":
        """Read a client's ``NAME.key_secret`` and the server's ``server.key``.

        Raises:
            LinkError: a file is not there or holds no key.
        """
        public, secret = _pair(secret_file)
        return cls(public, secret, _certificate(server_file)[0])


class ServerKeys(NamedTuple):
    """A server's pair (Z85), and the directory with its clients' public keys."""

    public: bytes
    secret: bytes
    clients: Path

    @classmethod
    def load(cls, directory: Path) -> "ServerKeys":
        """Read a server's key directory.

        Raises:
            LinkError: it is not a key directory, others can read the secret, or it has no client.
        """
        secret_file = directory / (SERVER + SECRET)
        public, secret = _pair(secret_file)
        if secret_file.stat().st_mode & 0o077:
            raise LinkError(f"{secret_file} can be read by others: chmod 600 it")
        clients = directory / CLIENTS
        allowed = sorted(clients.glob(f"*{PUBLIC}"))
        if not allowed:
            raise LinkError(f"{clients} holds no client's key, so no client could connect; add one")
        for file in allowed:
            _certificate(file)
        return cls(public, secret, clients)


def new_server_keys(directory: Path) -> Path:
    """Make a key directory with the server's pair, unless it has one; the public key's file.

    Raises:
        LinkError: it cannot be written.
    """
    public = directory / (SERVER + PUBLIC)
    with _writing(directory):
        (directory / CLIENTS).mkdir(mode=0o700, parents=True, exist_ok=True)
        if not public.exists():
            _create(directory, SERVER)
    return public


def new_client_keys(directory: Path, name: str) -> Path:
    """Make a client's pair and authorise it; the file to move to the client.

    Args:
        directory: of the server's keys.
        name: of the client.

    Raises:
        LinkError: the name is invalid or taken, or the directory cannot be written.
    """
    if not _CLIENT_NAME.fullmatch(name) or name == SERVER:
        raise LinkError(f"client name {name!r}: letters, digits, '_' or '-', not {SERVER!r}")
    public = directory / CLIENTS / (name + PUBLIC)
    if public.exists():
        raise LinkError(f"{public} is there already: remove it first to make new keys")
    with _writing(directory):
        _create(directory, name)
        (directory / (name + PUBLIC)).rename(public)
    return directory / (name + SECRET)


def authenticate(
    context: "zmq.Context[zmq.Socket[bytes]]", keys: ServerKeys
) -> ThreadAuthenticator:
    """Start a thread that admits only the clients of the directory; the caller stops it."""
    authenticator = ThreadAuthenticator(context)
    authenticator.start()
    authenticator.configure_curve(domain=DOMAIN.decode(), location=keys.clients)
    return authenticator


@contextmanager
def _writing(directory: Path) -> Iterator[None]:
    """Turn errors of the file system into ``LinkError``."""
    try:
        yield
    except OSError as error:
        raise LinkError(f"keys in {directory}: {error.strerror}") from error


def _create(directory: Path, name: str) -> None:
    """Create a pair of certificates; only the owner can read the secret one, from the start."""
    before = os.umask(0o077)
    try:
        create_certificates(directory, name)
    finally:
        os.umask(before)


def _certificate(file: Path) -> tuple[bytes, bytes | None]:
    try:
        return load_certificate(file)
    except (OSError, ValueError) as error:
        raise LinkError(f"{file} is not a key: {error}") from error


def _pair(file: Path) -> tuple[bytes, bytes]:
    public, secret = _certificate(file)
    if secret is None:
        raise LinkError(f"{file} holds no secret key; it is the file that ends in {SECRET}")
    return public, secret
