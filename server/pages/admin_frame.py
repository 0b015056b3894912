"""What all administrators' pages share: the study shown, its mode, and links that keep both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any
from urllib.parse import urlencode

from fastapi import Depends
from starlette.responses import Response

from server.deps import AdminDep, Services, ServicesDep
from server.export.bundle import MODES
from server.store.users import StaffRecord
from study.config import Study
from study.errors import InvalidValue, UnknownStudy

HIGHEST_PAGE = 1_000_000


@dataclass(frozen=True)
class Frame:
    """Who looks at which study; `mode` is "" for all modes."""

    services: Services
    user: StaffRecord
    study: Study
    mode: str

    @property
    def counted(self) -> str:
        """The mode that figures are about: the chosen one, or the one the study recruits in."""
        return self.mode or self.study.recruiting

    def page(self, template: str, values: Mapping[str, Any], status: int = 200) -> Response:
        """The page with everything that the frame needs."""
        frame = {
            "user": self.user,
            "study": self.study,
            "studies": list(self.services.participants.studies.values()),
            "mode": self.mode,
            "modes": MODES,
            "problems": {},
        }
        return self.services.renderer.page(template, frame | dict(values), status)


def find_frame(services: ServicesDep, user: AdminDep, study: str = "", mode: str = "") -> Frame:
    """The study that the address names, else the first; raises `UnknownStudy` or InvalidValue."""
    studies = services.participants.studies
    if not study and studies:
        study = next(iter(studies))
    if study not in studies:
        raise UnknownStudy(study)
    if mode and mode not in MODES:
        raise InvalidValue(
            f"there is no mode “{mode[:20]}”", next_step=f"Use one of {', '.join(MODES)}."
        )
    return Frame(services, user, studies[study], mode)


FrameDep = Annotated[Frame, Depends(find_frame)]


def clamp_page(page: int) -> int:
    """A page number that a database can count to."""
    return max(1, min(page, HIGHEST_PAGE))


def query_of(**fields: str | int | None) -> str:
    """The fields that hold something, as the query of an address that ends in `&` or `?`."""
    kept = {name: value for name, value in fields.items() if value not in ("", None)}
    return f"?{urlencode(kept)}&" if kept else "?"
