"""Administrators' pages about policies: the list, one as a matrix, comparing, activating."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from fastapi import APIRouter
from starlette.responses import RedirectResponse, Response

from server.deps import AdminDep, FormDep, ServicesDep, UploadDep
from server.desks.policies import ConfirmationNeeded, needs_confirmation
from server.pages.policy_tables import lay_out_policy
from server.pages.rendering import moment
from server.policy_files import shipped_policy
from server.store.policies import PolicyEntry
from server.store.users import StaffRecord
from study.errors import InvalidValue, NotFound, PolicyError
from study.learning.policy import Policy, read_policy

router = APIRouter(prefix="/admin/policies", include_in_schema=False)
PAGE_ROWS = 50
COMPARED = 100
_HASH_LETTERS = 12


@router.get("")
async def show_policies(
    services: ServicesDep, user: AdminDep, run: str = "", page: int = 1
) -> Response:
    """One page of policies, newest first; with `run` all versions of one learning run."""
    return await _list_page(services, user, run, page, {})


@router.post("")
async def upload_policy(services: ServicesDep, user: AdminDep, sent: UploadDep) -> Response:
    """Store an uploaded policy file and lead to its page; a bad one is refused with its fault."""
    try:
        policy = await services.policies.upload(sent.file, user.name)
    except PolicyError as error:
        place = "" if error.where == "policy file" else error.where
        told = PolicyError(error.what, where=place, next_step=error.next_step)
        return await _list_page(services, user, "", 1, {"file": _capital(told.sentence)})
    return RedirectResponse(f"/admin/policies/{policy.sha256}", 303)


@router.get("/{sha256}")
async def show_policy(
    sha256: str, services: ServicesDep, user: AdminDep, compare: str = ""
) -> Response:
    """One policy as a matrix, beside another one if `compare` names it."""
    return await _policy_page(services, user, sha256, compare, {}, {})


@router.get("/{sha256}/file.json")
async def download_policy(sha256: str, services: ServicesDep, user: AdminDep) -> Response:
    """The policy file, as it was stored."""
    del user
    entry = await services.policies.read_entry(sha256)
    name = f"policy-{entry.sha256[:_HASH_LETTERS]}.json"
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(entry.document, media_type="application/json", headers=headers)


@router.post("/{sha256}/activate")
async def activate_policy(
    sha256: str, services: ServicesDep, user: AdminDep, form: FormDep
) -> Response:
    """Let a study run this policy from now on; what stands against it is said beside the field."""
    confirmed = form.get("confirmed") == "yes"
    study_id = form.get("study", "")
    try:
        await services.policies.activate(sha256, study_id, user.name, confirmed=confirmed)
    except ConfirmationNeeded as error:
        problems = {"confirmed": _capital(error.sentence)}
        return await _policy_page(services, user, sha256, "", form, problems)
    except (InvalidValue, NotFound) as error:
        problems = {"study": _capital(error.sentence)}
        return await _policy_page(services, user, sha256, "", form, problems)
    return RedirectResponse(f"/admin/policies/{sha256}", 303)


@router.get("/{sha256}/activate")
async def lead_to_policy(sha256: str, user: AdminDep) -> Response:
    """The address of the sent form, opened by hand or loaded again."""
    del user
    return RedirectResponse(f"/admin/policies/{sha256}", 303)


async def _list_page(
    services: ServicesDep, user: StaffRecord, run: str, page: int, problems: Mapping[str, str]
) -> Response:
    page = max(1, min(page, 1_000_000))
    entries, total = await services.policies.list_policies(
        run, offset=(page - 1) * PAGE_ROWS, limit=PAGE_ROWS
    )
    shipped = shipped_policy().sha256
    values = {
        "user": user,
        "policies": [_row(entry, shipped) for entry in entries],
        "run": run[:32],
        "total": total,
        "page": page,
        "pages": max(1, -(-total // PAGE_ROWS)),
        "studies": await _active_rows(services),
        "labels": {"file": "Policy file"},
        "problems": problems,
    }
    return services.renderer.page("policies.html", values, 422 if problems else 200)


async def _policy_page(
    services: ServicesDep,
    user: StaffRecord,
    sha256: str,
    compare: str,
    typed: Mapping[str, str],
    problems: Mapping[str, str],
) -> Response:
    entry = await services.policies.read_entry(sha256)
    policy = read_policy(entry.document)
    other = None
    if compare:
        other = read_policy((await services.policies.read_entry(compare.strip())).document)
    known, _ = await services.policies.list_policies(offset=0, limit=COMPARED)
    adaptive = services.policies.adaptive_studies
    values = {
        "user": user,
        "policy": _row(entry, shipped_policy().sha256),
        "details": _details(policy),
        "thresholds": policy.thresholds.to_json(),
        "matrices": lay_out_policy(policy, other),
        "other": None if other is None else {"sha256": other.sha256, "name": other.name},
        "choices": [
            (k.sha256, f"{k.name} ({k.sha256[:_HASH_LETTERS]})") for k in known if k != entry
        ],
        "studies": [study.study_id for study in adaptive],
        "must_confirm": any(needs_confirmation(policy, study) for study in adaptive),
        "labels": {"study": "Study", "confirmed": "Confirmation"},
        "values": typed,
        "problems": problems,
    }
    return services.renderer.page("policy.html", values, 422 if problems else 200)


async def _active_rows(services: ServicesDep) -> list[dict[str, Any]]:
    """Which policy each study runs."""
    rows = []
    for study in services.policies.adaptive_studies:
        active = await services.policies.find_active(study)
        if active is not None:
            rows.append(
                {
                    "study": study.study_id,
                    "recruiting": study.recruiting,
                    "name": active.policy.name,
                    "origin": active.policy.origin,
                    "sha256": active.policy.sha256,
                    "chosen": active.chosen,
                    "warn": needs_confirmation(active.policy, study),
                }
            )
    return rows


def _row(entry: PolicyEntry, shipped: str) -> dict[str, Any]:
    training = json.loads(entry.document)["training"] or {"scores": {}}
    return {
        "sha256": entry.sha256,
        "short": entry.sha256[:_HASH_LETTERS],
        "name": entry.name,
        "origin": entry.origin,
        "is_shipped": entry.sha256 == shipped,
        "source": entry.source,
        "runs": entry.runs,
        "run_id": entry.run_id,
        "iteration": entry.iteration,
        "scores": {_score(name): round(value, 4) for name, value in training["scores"].items()},
        "trials": entry.trials,
        "studies": entry.studies,
        "added_at": moment(entry.added_at),
    }


def _details(policy: Policy) -> dict[str, str]:
    """What the file says about the training, as texts."""
    if policy.training is None:
        return {}
    training = policy.training
    return {
        "data (SHA-256)": training["data_sha256"],
        "seed": str(training["seed"]),
        "settings": _listed(training["settings"]),
        "scores before it": _listed({_score(k): v for k, v in training["scores"].items()}),
        "libraries": _listed(training["libraries"]),
    }


def _score(name: str) -> str:
    """A score's name for people: `off_rate_before` is the off rate of the iterations before."""
    return name.removesuffix("_before").replace("_", " ")


def _listed(record: Mapping[str, Any]) -> str:
    """Names and values as a text; a record within the record stands in brackets."""
    parts = (
        f"{name.replace('_', ' ')} ({_listed(value)})"
        if isinstance(value, Mapping)
        else f"{name.replace('_', ' ')} {value}"
        for name, value in record.items()
    )
    return ", ".join(parts) or "none"


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]
