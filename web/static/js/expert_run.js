// The expert's page of a running learning run: line, world, desk and gauges, wired together.

import { Desk } from "./expert_desk.js";
import { COLUMNS } from "./expert/board.js";
import { countDown, TICK_HZ, whyNotRecording } from "./expert/countdown.js";
import { CurveBook, MEASURES } from "./expert/curves.js";
import { describeLead } from "./expert/lead.js";
import { countWaiting, StateTimes } from "./expert/phases.js";
import { Connection } from "./net/connection.js";
import { decodeExpertText, encodeConfirm, encodeEdit, encodeExpertHello, encodeHandOver, encodeTakeLead, makeClient } from "./net/expert_messages.js";
import { CAMERA_MODES } from "./scene/cameras.js";
import { cellX, cellY } from "./scene/space.js";
import { Spectator } from "./spectator.js";
import { CameraBar } from "./ui/camera_bar.js";
import { CurveChart } from "./ui/curve_chart.js";
import { Gauges } from "./ui/gauges.js";
import { KeyHelp } from "./ui/key_help.js";
import { Notices } from "./ui/notices.js";
import { People } from "./ui/people.js";
import { RunBar } from "./ui/run_bar.js";

/** @typedef {import("./net/expert_messages.js").ExpertText} ExpertText */
/** @typedef {import("./net/messages.js").TextMessage | import("./net/messages.js").BinaryMessage} TrialMessage */
/** @typedef {import("./expert/edits.js").Gesture} Gesture */
/** @typedef {{ live: string, page: string, antialias: "auto" | "on" | "off" }} Addresses page: path of this page */

const GAUGES_EVERY_MS = 60;
const ROWS_EVERY_MS = 500;

/** What the picture says before the first word of the server. */
const OPENING = "Opening the run. If the server was just started, this may take a minute or two.";
/** What the picture says while the world stands. */
const PHASE_NOTES = /** @type {Record<string, string>} */ ({
  paused: "The world is paused until the worker is back.",
  countdown: "The world starts in a moment.",
  finished: "This trial is over. The next one begins in a moment.",
});

/** One expert's page. */
export class ExpertRun {
  /** @param {Document} document @param {Addresses} addresses */
  constructor(document, addresses) {
    this.document = document;
    this.addresses = addresses;
    const place = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
    this.stageElement = place("stage");
    this.client = makeClient();
    this.notices = new Notices(place("notices"));
    this.cameraBar = new CameraBar(place("cameras"), CAMERA_MODES, {
      choose: (mode) => this.spectator.choose(/** @type {import("./scene/cameras.js").CameraMode} */ (mode)),
      refit: () => this.spectator.cameras?.refit(),
      numbers: () => this.spectator.toggleNumbers(),
    });
    this.spectator = new Spectator(this.stageElement, addresses.antialias, {
      chosen: (agent) => this.desk?.choose(agent, this.desk.side),
      cameraChanged: (mode) => this.cameraBar.show(mode),
    });
    this.gauges = new Gauges(place("gauges"));
    this.curves = new CurveBook();
    this.chart = new CurveChart(place("curves"), MEASURES, this.curves);
    this.people = new People(place("people"), COLUMNS, {
      takeLead: () => this.connection.send(encodeTakeLead()),
      handOver: (client) => this.connection.send(encodeHandOver(client)),
    });
    this.bar = new RunBar({ facts: place("trial-facts"), recording: place("recording"), line: place("line") });
    this.help = new KeyHelp(document.body);
    place("help-button").addEventListener("click", () => this.help.toggle());
    this.agentsPlace = place("agents");
    this.times = new StateTimes();
    this.phase = "waiting";
    this.boxes = 0;
    this.isEnded = false;
    /** Whether the line is new, and what waits was not sent on it yet. */
    this.isCatchingUp = false;
    /** @type {string | null | undefined} client of the page that leads, null for nobody, undefined before the first word of it */
    this.lead = undefined;
    this.still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.notices.showNote(OPENING);
    this.connection = this.#connect();
    this.#start(/** @type {Window} */ (document.defaultView));
  }

  #connect() {
    return new Connection(
      this.addresses.live,
      { message: (message) => this.#hear(message), state: (state, reason) => this.#lineChanged(state, reason) },
      { hello: () => encodeExpertHello(this.client, this.desk?.edits.seq ?? 0), decode: decodeExpertText, greeting: "run" },
    );
  }

  /** @param {Window} window */
  #start(window) {
    const draw = (/** @type {number} */ now_ms) => {
      window.requestAnimationFrame(draw);
      this.spectator.draw(now_ms);
    };
    window.requestAnimationFrame(draw);
    window.setInterval(() => this.#showGauges(), GAUGES_EVERY_MS);
    window.setInterval(() => this.#showRows(), ROWS_EVERY_MS);
  }

  /** @param {ExpertText | TrialMessage} message */
  #hear(message) {
    const { desk } = this;
    if (message.type === "snapshot") {
      this.spectator.take(message);
      this.times.take(message.tick, message.robots);
    } else if (message.type === "plan") this.spectator.take(message);
    else if (message.type === "display") {
      this.spectator.take(message);
      desk?.board.show(message);
      desk?.render();
    } else if (message.type === "phase") this.#changePhase(message.phase);
    else if (message.type === "welcome") this.#begin(message);
    else if (message.type === "delivered") this.boxes = message.boxes;
    else this.#hearRun(/** @type {ExpertText} */ (message));
  }

  /** @param {ExpertText} message */
  #hearRun(message) {
    const { desk } = this;
    if (message.type === "run") this.#open(message);
    else if (message.type === "agents") {
      desk?.board.take(message);
      desk?.render(message.tick);
    } else if (message.type === "progress") this.progress = message;
    else if (message.type === "curve") {
      this.curves.take(message);
      this.chart.update();
    } else if (message.type === "stored") desk?.settle(message.seq);
    else if (message.type === "refused") desk?.refuse(message.seq, message.message);
    else if (message.type === "experts") this.#hearExperts(message.present, message.lead ?? null);
    else if (message.type === "agreement") this.people.showAgreement(message.experts);
    else if (message.type === "ended") this.#end(message.status);
  }

  /** @param {import("./ui/people.js").PresentExpert[]} present @param {string | null} lead */
  #hearExperts(present, lead) {
    const news = describeLead(this.lead, lead, this.client, present);
    this.lead = lead;
    this.people.show(present, lead, this.client);
    this.desk?.lead(lead === this.client);
    if (news) this.notices.say(news);
  }

  /** The line is open; the trial's welcome follows. @param {import("./net/expert_messages.js").Run} run */
  #open(run) {
    this.runFacts = run;
    if (!this.desk) {
      const desk = new Desk(this.agentsPlace, run, {
        moment: () => this.#moment(),
        send: (gesture) => this.#send(gesture),
        say: (text, isRefusal) => this.notices.say(text, isRefusal),
        chosen: (agent) => (this.spectator.chosen = agent),
      });
      this.desk = desk;
    }
    this.isCatchingUp = true;
  }

  /** Sends again what was not stored before the line broke, at the tick that the server is at now. @param {number} trial @param {number} tick */
  #catchUp(trial, tick) {
    this.isCatchingUp = false;
    const edits = this.desk?.edits;
    edits?.rewind(trial, tick);
    for (const gesture of edits?.pending ?? []) this.#send(gesture);
  }

  /** Sends a gesture, unless older ones are to be sent first: then it waits among them. @param {Gesture} gesture */
  #send(gesture) {
    if (this.isCatchingUp) return;
    const { seq, kind, changes, agents } = gesture;
    this.connection.send(kind === "edit" ? encodeEdit(seq, gesture, changes) : encodeConfirm(seq, gesture, agents));
  }

  /** The moment that the expert sees, or why nothing can be set now. @returns {{ trial: number, tick: number } | string} */
  #moment() {
    const { welcome } = this;
    if (this.isEnded) return "The run has ended.";
    if (this.connection.state !== "open") return "There is no connection: nothing can be set until it is back.";
    if (!welcome || this.phase === "finished") return "There is no trial at the moment; the next one begins soon.";
    const newest_tick = this.spectator.snapshots.newest?.tick ?? welcome.tick;
    return { trial: welcome.trial ?? 0, tick: Math.max(0, Math.min(newest_tick, Math.floor(this.spectator.tick))) };
  }

  /** @param {import("./net/messages.js").Welcome & { trial?: number }} welcome */
  #begin(welcome) {
    if (this.welcome?.trial_id !== welcome.trial_id) {
      this.times.clear();
      this.desk?.beginTrial();
    }
    this.welcome = welcome;
    this.boxes = welcome.boxes_delivered;
    this.bays = welcome.hall.stations.map(({ bays }) => ({ bays: bays.map(([i, j]) => /** @type {[number, number]} */ ([cellX(i), cellY(j)])) }));
    this.spectator.begin(welcome);
    if (this.isCatchingUp) this.#catchUp(welcome.trial ?? 0, welcome.tick);
  }

  /** @param {string} phase */
  #changePhase(phase) {
    this.phase = phase;
    this.spectator.setRunning(phase === "running");
    const waits = this.runFacts?.worker === "person" ? "Waiting for the worker to open their link." : "Waiting for the simulated worker.";
    this.notices.showNote(phase === "waiting" ? waits : (PHASE_NOTES[phase] ?? ""));
  }

  #showGauges() {
    const now_ms = performance.now();
    const { desk, runFacts: run, progress, connection } = this;
    this.notices.tick(now_ms);
    this.gauges.tick(now_ms);
    const changes = { stored: desk?.edits.stored ?? 0, pending: desk?.edits.pending.length ?? 0 };
    if (this.isEnded) this.bar.hideLine();
    else this.bar.showLine(connection.state === "open", connection.roundTrip_ms, changes);
    const reason = whyNotRecording({
      connected: connection.state === "open", phase: this.phase, ended: this.isEnded, lead: this.lead,
      recording: desk?.board.recording ?? false, worker: run?.worker ?? "person",
    });
    this.bar.showRecording(reason);
    const left = countDown(this.spectator.tick, progress?.next_snapshot_tick ?? 0, run?.snapshot_ticks ?? 0);
    this.gauges.showRing({ ...left, reason, still: this.still });
    if (progress && run && desk) this.#showCounts(progress, run, desk, now_ms);
    if (connection.state === "lost" || connection.state === "connecting") this.#showLost(changes);
    this.#writeFacts(changes);
  }

  /** @param {import("./net/expert_messages.js").Progress} progress @param {import("./net/expert_messages.js").Run} run @param {Desk} desk @param {number} now_ms */
  #showCounts(progress, run, desk, now_ms) {
    this.gauges.showCounts({
      pairs: progress.pairs, pairsTotal: run.pairs_per_iteration * progress.iterations, iteration: progress.iteration,
      iterations: progress.iterations, inIteration: progress.units % run.pairs_per_iteration, perIteration: run.pairs_per_iteration,
      beta: progress.beta, byExpert: desk.board.shownByExpert, agents: desk.board.agents, isLead: desk.isLead,
    }, now_ms);
  }

  #showRows() {
    const { desk, welcome } = this;
    if (!desk || !welcome) return;
    const tick = Math.floor(this.spectator.tick);
    const robots = this.spectator.snapshots.newest?.robots ?? [];
    robots.forEach((_, robot) => (desk.statuses[robot] = this.times.describe(robot)));
    countWaiting(robots, this.bays ?? []).forEach((waiting, station) =>
      (desk.statuses[desk.board.robots + station] = waiting ? `${waiting} waiting` : ""));
    desk.render(tick);
    this.bar.showTrial({ trial: welcome.trial ?? 0, seconds: tick / TICK_HZ, boxes: this.boxes, boxesTotal: welcome.boxes_total });
  }

  /** @param {{ stored: number, pending: number }} changes */
  #showLost({ stored, pending }) {
    if (this.isEnded || (!this.runFacts && this.connection.state === "connecting")) return;
    this.notices.showBanner("lost", "Connection lost", [
      `Your changes: ${stored} stored, ${pending ? `${pending} still waiting, to be sent again as soon as the line is back` : "none waiting"}.`,
      "This page is trying to reconnect. Until then you see the last known moment, and nothing can be set.",
    ]);
  }

  /** @param {import("./net/connection.js").ConnectionState} state @param {string} reason */
  #lineChanged(state, reason) {
    if (state === "open") this.notices.hideBanner();
    if (state !== "open") this.spectator.setRunning(false);
    if (state !== "refused" && state !== "taken-over" && state !== "reload") return;
    this.notices.showNote("");
    this.notices.showBanner("refused", "This page cannot go on", [reason || "The server closed the line.", "Load the page again; if that does not help, sign in anew."]);
  }

  /** @param {"finished" | "stopped"} status */
  #end(status) {
    this.isEnded = true;
    this.connection.finish();
    const { progress, addresses, desk } = this;
    const unsaved = desk?.edits.pending.length ? [`${desk.edits.pending.length} of your last changes came too late and were not stored.`] : [];
    this.document.getElementById("worker-link")?.remove();
    this.notices.showNote("");
    this.notices.showBanner("ended", status === "finished" ? "The run is finished" : "The run was stopped", [
      `${progress?.pairs ?? 0} pairs and ${progress?.iteration ?? 0} iterations are stored.`, ...unsaved,
    ], [
      { text: "Dataset (CSV)", address: `${addresses.page}/dataset.csv` },
      { text: "Latest policy (JSON)", address: `${addresses.page}/policies/latest.json` },
      { text: "All runs", address: "/expert" },
    ]);
  }

  /** Facts for tests and anybody who wants to know what the page thinks. @param {{ stored: number, pending: number }} changes */
  #writeFacts({ stored, pending }) {
    const { desk, progress } = this;
    Object.assign(this.stageElement.dataset, {
      phase: this.phase, connection: this.connection.state, tick: String(Math.floor(this.spectator.tick)),
      trial: String(this.welcome?.trial ?? -1), frames: String(this.spectator.frames), camera: this.spectator.cameras?.mode ?? "",
      pairs: String(progress?.pairs ?? 0), iteration: String(progress?.iteration ?? 0), pending: String(pending), stored: String(stored),
      boxes: desk?.board.isKnown ? desk.heads.map((_, agent) => desk.board.box(agent)).join(",") : "",
      shown: desk?.board.shown.join(",") ?? "", recording: String(desk?.board.recording ?? false), client: this.client,
    });
  }
}
