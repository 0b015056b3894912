"""The description of `/api/v1` as OpenAPI, made from the routes themselves."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.openapi.utils import get_openapi

from server.api import bots, people, policies, studies
from server.api.records import Problem
from server.deps import AdminDep
from server.signin import COOKIE

ROUTERS = (studies.router, people.router, policies.router, bots.router)
router = APIRouter(prefix="/api/v1", include_in_schema=False)
_ABOUT = (
    "What staff see, as JSON. Sign in at `/login` (a form with `name` and `password`) and send the "
    "cookie along; administrators only. Lists are paged by `offset` and `limit`. Whatever is "
    "refused is answered as `application/problem+json` with `detail` and `next_step`."
)
_REFUSALS = {
    "401": "Nobody is signed in",
    "403": "The role does not cover this, or another site asked",
    "404": "There is no such thing",
    "409": "This does not fit what is going on",
    "422": "The request does not fit this description",
    "503": "The storage does not answer; try again",
}


def describe_api() -> dict[str, Any]:
    """The OpenAPI document."""
    routes = [route for one in ROUTERS for route in one.routes]
    document = get_openapi(
        title="VARIL", version="1", openapi_version="3.1.0", description=_ABOUT, routes=routes
    )
    parts = document["components"]
    parts["schemas"]["Problem"] = Problem.model_json_schema()
    parts["securitySchemes"] = {"signIn": {"type": "apiKey", "in": "cookie", "name": COOKIE}}
    for name in ("HTTPValidationError", "ValidationError"):
        parts["schemas"].pop(name, None)
    document["security"] = [{"signIn": []}]
    schema = {"$ref": "#/components/schemas/Problem"}
    for methods in document["paths"].values():
        for operation in methods.values():
            for status, words in _REFUSALS.items():
                operation["responses"][status] = {
                    "description": words,
                    "content": {"application/problem+json": {"schema": schema}},
                }
    return document


@router.get("/openapi.json")
async def show_description(request: Request, user: AdminDep) -> dict[str, Any]:
    """The OpenAPI document; made once."""
    state = request.app.state
    if not hasattr(state, "api_description"):
        state.api_description = describe_api()
    known: dict[str, Any] = state.api_description
    return known
