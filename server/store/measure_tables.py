"""Tables of what an ended trial is measured by."""

from __future__ import annotations

from sqlalchemy import ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from server.store.base import Base


class TrialQuality(Base):
    """How well the connection, the picture and the attention were in one ended trial."""

    __tablename__ = "trial_quality"
    trial_id: Mapped[str] = mapped_column(ForeignKey("trials.id"), primary_key=True)
    rtt_median_ms: Mapped[float | None]
    rtt_p95_ms: Mapped[float | None]
    frame_rate_median_hz: Mapped[float | None]
    frame_rate_p5_hz: Mapped[float | None]
    long_frames: Mapped[int | None]
    longest_frame_ms: Mapped[float | None]
    hidden_s: Mapped[float | None]
    unfocused_s: Mapped[float | None]
    pointer_lock_losses: Mapped[int | None]
    pauses: Mapped[int]
    paused_s: Mapped[float]
    idle_s: Mapped[float]
    tick_late_p99_ms: Mapped[float | None]
    tick_late_max_ms: Mapped[float | None]
    connections: Mapped[int]
    reports: Mapped[int]


class TrialRobot(Base):
    """Measures of one robot in one ended trial."""

    __tablename__ = "trial_robots"
    trial_id: Mapped[str] = mapped_column(ForeignKey("trials.id"), primary_key=True)
    robot: Mapped[int] = mapped_column(primary_key=True)
    boxes_delivered: Mapped[int]
    wait_s: Mapped[float]
    completion_s: Mapped[float]
    path_m: Mapped[float]
    longest_stall_s: Mapped[float]
    blocked_by_human_s: Mapped[float]


class TrialLeg(Base):
    """A stretch of a robot's life in one state, in one ended trial."""

    __tablename__ = "trial_legs"
    trial_id: Mapped[str] = mapped_column(ForeignKey("trials.id"), primary_key=True)
    robot: Mapped[int] = mapped_column(primary_key=True)
    leg: Mapped[int] = mapped_column(primary_key=True)
    state: Mapped[str] = mapped_column(String(20))
    start_s: Mapped[float]
    end_s: Mapped[float]
    path_m: Mapped[float]
    shelf: Mapped[int | None]
    box: Mapped[int | None]
    station: Mapped[int | None]
    ended: Mapped[bool]
