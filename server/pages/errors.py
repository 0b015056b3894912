"""Pages and JSON for what went wrong: what happened, and what to do next."""

from __future__ import annotations

import re
from typing import Any

from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from server.pages.rendering import Renderer
from server.problems import Problem, SignInNeeded, problem_of
from server.tokens import looks_like_token
from study.errors import NotFound, StudyError, UnknownToken

_OURS = Problem(500, "Something went wrong on our side", 1011)
_PERSONAL = re.compile(r"^/p/(?P<token>[^/]+)")
_WORKERS = re.compile(r"^/w/[A-Za-z0-9_-]+$")
_HEADLINES = {
    404: "There is nothing at this address",
    405: "This address does not take that kind of request",
}


async def answer_error(
    renderer: Renderer, request: Request, error: Exception, reference: str = ""
) -> Response:
    """The answer to a request that failed; JSON where JSON was asked for, a page elsewhere."""
    problem, what, next_step = _describe(error)
    if request.url.path.startswith("/api/"):
        return _tell_program(problem, what, next_step, reference)
    if _wants_json(request):
        body = {"error": what, "next_step": next_step, "reference": reference}
        return JSONResponse({k: v for k, v in body.items() if v}, problem.status)
    if isinstance(error, SignInNeeded) and request.method == "GET":
        return RedirectResponse("/login", 303)
    values = {
        "brand": "Studies with people and robots",
        "headline": problem.headline,
        "what": what[:1].upper() + what[1:],
        "next_step": next_step,
        "reference": reference,
        "way_out": _way_out(request, error),
    }
    return renderer.page("error.html", values, problem.status)


def _tell_program(problem: Problem, what: str, next_step: str, reference: str) -> Response:
    """The problem as RFC 9457 has it, with what to do next beside it."""
    body = {
        "type": "about:blank",
        "title": problem.headline,
        "status": problem.status,
        "detail": what,
        "next_step": next_step,
        "reference": reference,
    }
    return JSONResponse(body, problem.status, media_type="application/problem+json")


def _describe(error: Exception) -> tuple[Problem, str, str]:
    if isinstance(error, StudyError):
        return problem_of(error), error.what, error.next_step
    if isinstance(error, HTTPException):
        headline = _HEADLINES.get(error.status_code, "The server could not read this request")
        what = {404: "the address may be incomplete or out of date"}.get(
            error.status_code, f"the request was refused ({error.detail})"
        )
        return (
            Problem(error.status_code, headline, 4400),
            what,
            "Check the address, or go back and try once more.",
        )
    if isinstance(error, RequestValidationError):
        wrong = ", ".join(str(problem["loc"][-1]) for problem in error.errors())
        return (
            Problem(422, "The server could not read this request", 4400),
            f"the address carries something unusable ({wrong})",
            "Go back and follow the links of the page.",
        )
    return (
        _OURS,
        "the server made a mistake and noted it",
        "What you sent may not have been stored. Please go back and try once more.",
    )


def _wants_json(request: Request) -> bool:
    accepts = request.headers.get("accept", "")
    machine = request.url.path.startswith(("/api/", "/healthz", "/readyz", "/metrics"))
    return machine or ("application/json" in accepts and "text/html" not in accepts)


def _way_out(request: Request, error: Exception) -> dict[str, Any]:
    path = request.url.path
    personal = _PERSONAL.match(path)
    known = personal is not None and looks_like_token(personal["token"])
    if personal is not None and known and not isinstance(error, UnknownToken):
        return {"address": f"/p/{personal['token']}", "text": "Go to the current step"}
    if _WORKERS.match(path) and not isinstance(error, NotFound):
        return {"address": path, "text": "Load the page again"}
    if path.startswith(("/admin", "/expert", "/login")):
        return {"address": "/login", "text": "Go to your start page"}
    return {"address": "/", "text": "Go to the start page"}
