"""Everything that the environment may set, as one typed class. There is no default secret."""

from __future__ import annotations

import os
import secrets
from pathlib import Path
from typing import Annotated

from pydantic import Field, SecretStr
from pydantic_settings import BaseSettings, SettingsConfigDict

from study.errors import InvalidValue


class Settings(BaseSettings):
    """Settings of the server, read from `VARIL_*` variables.

    Attributes:
        host, port: where the server listens.
        database_url: `sqlite:///file`, `sqlite:////absolute/file` or `postgresql://...`.
        var_dir: folder for the embedded database and the secret key.
        secret_key: signs cookies and join links; unset, one is made in `var_dir`.
        admin_password: of the account `admin`, made when no admin exists.
        metrics_token: lets other machines than this one read `/metrics`.
        trusted_proxy: address of a proxy whose X-Forwarded-For and -Proto are believed.
        allowed_origins: further origins (scheme://host[:port]) behind which the server is reached.
        study_files: study files to serve; the demo study where none is given.
        time_scale: world seconds per second; refused for live participants unless 1.
    """

    model_config = SettingsConfigDict(env_prefix="VARIL_", frozen=True, extra="ignore")

    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 8000
    var_dir: Path = Path("var")
    database_url: str = ""
    secret_key: Annotated[SecretStr, Field(min_length=32)] | None = None
    admin_password: Annotated[SecretStr, Field(min_length=10)] | None = None
    metrics_token: SecretStr | None = None
    trusted_proxy: str = ""
    allowed_origins: tuple[str, ...] = ()
    study_files: tuple[Path, ...] = ()
    time_scale: Annotated[float, Field(ge=1.0, le=4.0)] = 1.0

    @property
    def database(self) -> str:
        """The database's address; by default a SQLite file under `var_dir`."""
        return self.database_url or f"sqlite:///{self.var_dir / 'varil.sqlite3'}"

    def read_secret_key(self) -> bytes:
        """The configured key, or the one kept as `var/secret_key` (made once, mode 0600)."""
        if self.secret_key is not None:
            return self.secret_key.get_secret_value().encode()
        file = self.var_dir / "secret_key"
        self.var_dir.mkdir(parents=True, exist_ok=True)
        try:
            handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        except FileExistsError:
            return _read_key(file)
        with os.fdopen(handle, "w") as out:
            out.write(secrets.token_urlsafe(48))
        return _read_key(file)


def _read_key(file: Path) -> bytes:
    key = file.read_bytes().strip()
    if len(key) < 32:
        raise InvalidValue(
            f"{file} holds no usable key",
            next_step="Delete it to have a new one made; staff will have to sign in again.",
        )
    return key
