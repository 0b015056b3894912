"""Policies: which there are, and what is in one."""

from __future__ import annotations

import json
from typing import Any

from fastapi import APIRouter

from server.api.records import Limit, Name, Offset, Page, Policy
from server.deps import AdminDep, ServicesDep

router = APIRouter(prefix="/api/v1/policies", tags=["policies"])
_FIELDS = ("sha256", "name", "origin", "source", "added_at", "runs", "trials", "studies")


@router.get("")
async def list_policies(
    services: ServicesDep, user: AdminDep, offset: Offset = 0, limit: Limit = 100
) -> Page[Policy]:
    """One page of stored policies, newest first."""
    entries, total = await services.policies.list_policies(offset=offset, limit=limit)
    items = [Policy(**{name: getattr(entry, name) for name in _FIELDS}) for entry in entries]
    return Page(total=total, offset=offset, limit=limit, items=items)


@router.get("/{sha256}")
async def read_policy(sha256: Name, services: ServicesDep, user: AdminDep) -> dict[str, Any]:
    """A policy's file, as `varil simulate --policy` reads it."""
    entry = await services.policies.read_entry(sha256)
    document: dict[str, Any] = json.loads(entry.document)
    return document
