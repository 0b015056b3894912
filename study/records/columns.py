"""Columns that several tables of the export share."""

from __future__ import annotations

from study.records.cells import Column

STUDY = Column("study_id", "text", "the study")
HASH = Column("config_hash", "text", "SHA-256 of the version of the study that was joined")
MODE = Column("mode", "text", "live, pilot or bot; fixed when joining")
BOT = Column("is_bot", "boolean", "true for simulated participants")
CODE = Column("participant_code", "text", "random code of the participant")
TRIAL = Column("trial_id", "text", "the trial")
ROBOT = Column("robot", "integer", "index of the robot, from 0")
POSITION = Column("position", "integer", "1 for the first trial of a participant, and so on")
CONDITION = Column("condition", "text", "what decided about the display")

ORIGIN = (STUDY, HASH, MODE, BOT)
