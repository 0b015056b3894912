"""Tables of what was observed of trials besides their measures, and of what experts said."""

from __future__ import annotations

from study.records.cells import Column, Table
from study.records.columns import CODE, CONDITION, ORIGIN, POSITION, TRIAL

EVENTS = Table(
    "events",
    "one row per event of each trial; the kinds are described in codebook.csv",
    (
        TRIAL,
        Column("number", "integer", "number of the event in its trial, from 0"),
        Column("tick", "integer", "step of the world at which it happened, of 1/30 s"),
        Column("time_s", "number", "the same in seconds from the start of the trial", "s"),
        Column("kind", "text", "what happened; see codebook.csv"),
        Column("data", "text", "the event's fields as one JSON object; see codebook.csv"),
        Column("at", "time", "the time of day"),
        CODE,
        *ORIGIN,
    ),
    key=("trial_id", "number"),
    refers=(("trial_id", "trials"),),
)

QUALITY = Table(
    "quality",
    "one row per ended trial: how good its conditions were; empty = not measured",
    (
        TRIAL,
        CODE,
        POSITION,
        CONDITION,
        Column("rtt_median_ms", "number", "round-trip time, median", "ms"),
        Column("rtt_p95_ms", "number", "round-trip time that 95 % stayed below", "ms"),
        Column("frame_rate_median_hz", "number", "frames drawn a second, median", "Hz"),
        Column("frame_rate_p5_hz", "number", "frame rate that 95 % of the seconds exceeded", "Hz"),
        Column("long_frames", "integer", "frames that took longer than 50 ms"),
        Column("longest_frame_ms", "number", "the longest time between two frames", "ms"),
        Column("hidden_s", "number", "time in which the page was hidden", "s"),
        Column("unfocused_s", "number", "time in which the page had not the keyboard", "s"),
        Column("pointer_lock_losses", "integer", "how often the pointer was set free"),
        Column("pauses", "integer", "how often the world was paused"),
        Column("paused_s", "number", "how long the world was paused", "s"),
        Column("idle_s", "number", "time without any input of 5 s or longer at a stretch", "s"),
        Column("tick_late_p99_ms", "number", "lateness that 99 % of the ticks stayed below", "ms"),
        Column("tick_late_max_ms", "number", "lateness of the latest tick", "ms"),
        Column("connections", "integer", "how often a page joined the trial"),
        Column("reports", "integer", "how many reports of the page the figures rest on"),
        Column("flags", "text", "exclusion rules that the trial breaks, joined by |"),
        *ORIGIN,
    ),
    key=("trial_id",),
    refers=(("trial_id", "trials"),),
)

NOTES = Table(
    "notes",
    "one row per note that staff wrote about a participant or about a moment of a trial",
    (
        CODE,
        Column("number", "integer", "number of the note among those of the participant, from 0"),
        Column(
            "trial_id",
            "text",
            "the trial, the practice included; empty for a note about the participant",
        ),
        Column("step", "text", "the trial's step: practice, or trial- and the position"),
        Column("tick", "integer", "step of the trial's world that it is about, of 1/30 s"),
        Column("time_s", "number", "the same in seconds from the start of the trial", "s"),
        Column("text", "text", "what was written; by whom stands in the audit log alone"),
        Column("written_at", "time", "when it was kept"),
        *ORIGIN,
    ),
    key=("participant_code", "number"),
    refers=(("participant_code", "participants"),),
)

EXPERT_LABELS = Table(
    "expert_labels",
    "one row per pair of the live learning runs that taught the policies of these trials",
    (
        Column("run_id", "text", "the learning run"),
        Column("number", "integer", "number of the pair in its run, from 0"),
        Column("iteration", "integer", "iteration of PolicyUp that it belongs to"),
        Column("trial", "integer", "number of the trial within the run, from 1"),
        Column("trial_seed", "integer", "seed of that trial's world"),
        Column("tick", "integer", "step of that world at the snapshot, of 1/30 s"),
        Column("domain", "text", "robot or station"),
        Column("agent", "integer", "index of the agent within its domain, from 0"),
        Column("state", "integer", "the agent's state"),
        Column("box", "integer", "elements that the expert had set, added up"),
        Column("proposal", "integer", "elements that the policy proposed, added up"),
        Column("drawn", "integer", "elements that drew anything at that moment, added up"),
        Column("label", "integer", "elements that the pair teaches, added up"),
        Column(
            "edit_ticks", "integer", "ticks since the expert last changed this agent, -1 = never"
        ),
        Column("by_expert", "boolean", "true while the boxes decided what was shown"),
        *ORIGIN,
    ),
    key=("run_id", "number"),
)

PANEL_IDS = Table(
    "panel_ids",
    "what a recruitment panel calls the participants; only given when asked for",
    (
        CODE,
        Column("name", "text", "name of the parameter"),
        Column("value", "text", "its value"),
        *ORIGIN,
    ),
    key=("participant_code", "name"),
    refers=(("participant_code", "participants"),),
)

TELEMETRY = Table(
    "telemetry",
    "where the person was, five times a second, re-simulated from the stored inputs",
    (
        TRIAL,
        Column("tick", "integer", "step of the world, of 1/30 s"),
        Column("time_s", "number", "the same in seconds from the start of the trial", "s"),
        Column("x_m", "number", "place of the person", "m"),
        Column("y_m", "number", "place of the person", "m"),
        Column("yaw_rad", "number", "heading of the view, anticlockwise from +x", "rad"),
    ),
    key=("tick",),
)
"""Of each file `telemetry/<trial>.csv.gz`."""
