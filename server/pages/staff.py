"""Staff's sign-in and sign-out."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request
from starlette.responses import RedirectResponse, Response

from server.deps import FormDep, ServicesDep, StaffDep, find_staff
from server.desks.accounts import check_password
from server.problems import TooOften, problem_of
from server.signin import COOKIE, SESSION_S
from server.store.users import StaffRecord

router = APIRouter(include_in_schema=False)
_HOMES = {"admin": "/admin", "expert": "/expert"}


@router.get("/login")
async def show_login(
    services: ServicesDep, user: Annotated[StaffRecord | None, Depends(find_staff)]
) -> Response:
    """The sign-in form; whoever is signed in is led to the own page."""
    if user is not None:
        return RedirectResponse(_HOMES[user.role], 303)
    return _login_page(services, "", None)


@router.post("/login")
async def sign_in(request: Request, form: FormDep, services: ServicesDep) -> Response:
    """Check name and password; a wrong pair and an unknown name look the same."""
    name, password = form.get("name", "").strip(), form.get("password", "")
    host = request.client.host if request.client else ""
    try:
        await services.sign_ins.count_attempt(name, host)
    except TooOften as error:
        page = _login_page(services, name, error.sentence, problem_of(error).status)
        page.headers["Retry-After"] = str(error.wait_s)
        return page
    user = await check_password(services.database, name, password)
    action = "signed in" if user else "sign-in refused"
    await services.audit.note(user.name if user else name or "-", action)
    if user is None:
        return _login_page(services, name, "Name or password is wrong. Please try again.", 401)
    answer = RedirectResponse(_HOMES[user.role], 303)
    answer.set_cookie(
        COOKIE,
        services.sign_ins.sign(user),
        max_age=SESSION_S,
        httponly=True,
        samesite="lax",
        secure=request.url.scheme == "https",
    )
    return answer


@router.post("/logout")
async def sign_out(services: ServicesDep, user: StaffDep) -> Response:
    """Forget the sign-in in this browser."""
    await services.audit.note(user.name, "signed out")
    answer = RedirectResponse("/login", 303)
    answer.delete_cookie(COOKIE, httponly=True, samesite="lax")
    return answer


def _login_page(
    services: ServicesDep, name: str, problem: str | None, status: int = 200
) -> Response:
    values = {"brand": "Studies with people and robots", "name": name, "problem": problem}
    return services.renderer.page("login.html", values, status)
