// The expert's page without a screen: gestures, the grid's facts, keys, countdown, curves.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Board, COLUMNS } from "../../web/static/js/expert/board.js";
import { countDown, whyNotRecording } from "../../web/static/js/expert/countdown.js";
import { CurveBook } from "../../web/static/js/expert/curves.js";
import { Edits } from "../../web/static/js/expert/edits.js";
import { describeLead } from "../../web/static/js/expert/lead.js";
import { countWaiting, StateTimes } from "../../web/static/js/expert/phases.js";
import { decodeExpertText, encodeConfirm, encodeEdit, encodeExpertHello } from "../../web/static/js/net/expert_messages.js";
import { WireError } from "../../web/static/js/net/messages.js";

const NOW = { trial: 2, tick: 300 };
/** @param {Partial<import("../../web/static/js/expert/board.js").AgentsMessage>} facts */
const agents = (facts) => ({ trial: 2, tick: 300, boxes: [7, 7, 1], proposals: [0, 0, 0], drawn: [7, 1, 0], by_expert: [1, 0, 1], recording: true, taken_seq: 0, ...facts });

function makeBoard() {
  const edits = new Edits();
  const board = new Board(2, 1, edits);
  board.take(agents({}));
  return { edits, board };
}

test("a toggle shows at once, is pending until stored, and survives the server's older word", () => {
  const { edits, board } = makeBoard();
  const gesture = edits.edit(NOW, board.toggleCell(0, 4));
  assert.deepEqual(gesture.changes, [[0, 0, 4]]);
  assert.deepEqual(board.cell(0, 4), { on: false, shown: false, drawn: true, proposed: false, pending: true });
  board.take(agents({ taken_seq: 0 }));
  assert.equal(board.cell(0, 4).on, false, "a message from before the gesture does not undo it");
  board.take(agents({ boxes: [3, 7, 1], taken_seq: 1 }));
  assert.equal(board.cell(0, 4).pending, true);
  assert.deepEqual(edits.settle(1), [gesture]);
  assert.deepEqual([board.cell(0, 4).on, board.cell(0, 4).pending, edits.stored], [false, false, 1]);
});

test("once the server has shown a gesture, what the policy proposes later is seen although storing lasts", () => {
  const { edits, board } = makeBoard();
  edits.edit(NOW, board.toggleCell(0, 4));
  board.take(agents({ boxes: [3, 7, 1], taken_seq: 1 }));
  board.take(agents({ boxes: [7, 7, 1], taken_seq: 1 }));
  assert.deepEqual([board.cell(0, 4).on, board.cell(0, 4).pending], [true, true]);
});

test("an element switched off and on again shows the last of both, whichever words arrive", () => {
  const { edits, board } = makeBoard();
  edits.edit(NOW, board.toggleCell(0, 4));
  edits.edit(NOW, board.toggleCell(0, 4));
  board.take(agents({}));
  board.take(agents({ boxes: [3, 7, 1], taken_seq: 1 }));
  assert.equal(board.cell(0, 4).on, true, "the second is still on its way");
  board.take(agents({ boxes: [7, 7, 1], taken_seq: 2 }));
  assert.equal(board.cell(0, 4).on, true);
});

test("after a server was killed, what waits is sent for the tick to which the trial went back", () => {
  const { edits, board } = makeBoard();
  edits.edit({ trial: 1, tick: 900 }, board.toggleCell(1, 1));
  edits.edit({ trial: 2, tick: 260 }, board.toggleCell(1, 2));
  edits.edit(NOW, board.toggleCell(0, 4));
  board.take(agents({ boxes: [3, 4, 1], taken_seq: 3 }));
  edits.rewind(2, 270);
  assert.deepEqual(edits.pending.map(({ trial, tick }) => [trial, tick]), [[1, 900], [2, 260], [2, 270]]);
  board.take(agents({}));
  assert.equal(board.cell(0, 4).on, false, "the new server does not hold it yet");
});

test("a refused gesture leaves no trace, not even for undo", () => {
  const { edits, board } = makeBoard();
  edits.edit(NOW, board.toggleCell(0, 4));
  assert.deepEqual(edits.refuse(1)?.changes, [[0, 0, 4]]);
  assert.equal(board.cell(0, 4).on, true);
  assert.equal(edits.undo(NOW), null);
  assert.equal(edits.refuse(9), null);
});

test("what was not stored stays in order, to be sent again after a lost line", () => {
  const { edits, board } = makeBoard();
  edits.edit(NOW, board.toggleCell(0, 4));
  edits.confirm(NOW, [1]);
  edits.edit(NOW, board.toggleRow(1));
  edits.settle(1);
  assert.deepEqual(edits.pending.map(({ seq, kind }) => [seq, kind]), [[2, "confirm"], [3, "edit"]]);
  assert.ok(edits.isConfirming(1) && !edits.isConfirming(0));
});

test("undo sends the inverse of the last own gestures, one after the other", () => {
  const { edits, board } = makeBoard();
  edits.edit(NOW, board.toggleCell(0, 4));
  edits.edit(NOW, board.toggleColumn(/** @type {typeof COLUMNS[number]} */ (COLUMNS[1])));
  assert.deepEqual(edits.undo(NOW)?.changes, [[0, 1, 0], [1, 1, 0]]);
  assert.deepEqual(edits.undo(NOW)?.changes, [[0, 4, 0]]);
  assert.equal(edits.undo(NOW), null);
  assert.deepEqual([board.box(0), board.box(1)], [7, 7]);
  assert.equal(edits.seq, 4, "an undo is a gesture of its own");
});

test("who goes over to other boxes takes nothing back that was done to the former ones", () => {
  const { edits, board } = makeBoard();
  edits.edit(NOW, board.toggleCell(0, 4));
  edits.forgetUndo();
  assert.equal(edits.undo(NOW), null);
  assert.equal(edits.pending.length, 1, "what was done goes on to be stored");
});

test("a change of the lead is told to who gets it, who gives it and who looks on, and only then", () => {
  const present = [{ name: "anna", client: "a" }, { name: "ben", client: "b" }];
  const tell = (/** @type {string | null | undefined} */ former, /** @type {string | null} */ lead) => describeLead(former, lead, "a", present);
  for (const [former, lead] of /** @type {[string | null | undefined, string | null][]} */ ([[undefined, "a"], [undefined, "b"], ["a", "a"], ["b", null]])) assert.equal(tell(former, lead), "");
  assert.match(tell("b", "a"), /^You have the lead/);
  assert.match(tell(null, "a"), /^You have the lead/);
  assert.match(tell("a", "b"), /^ben has the lead: your settings are kept apart/);
  assert.match(tell(null, "b"), /^ben has the lead now/);
});

test("rows and columns go off only when all of them is on, and change only what differs", () => {
  const { edits, board } = makeBoard();
  assert.deepEqual(board.toggleRow(0), [[0, 0, 7]]);
  edits.edit(NOW, board.toggleCell(0, 2));
  assert.deepEqual(board.toggleRow(0), [[0, 2, 0]]);
  const [trajectory, , ghost, balloon] = COLUMNS;
  assert.ok(trajectory && ghost && balloon);
  assert.deepEqual(board.toggleColumn(ghost), [[0, 2, 0]]);
  assert.deepEqual(board.toggleColumn(trajectory), [[0, 0, 4], [1, 0, 4]]);
  assert.deepEqual(board.toggleColumn(balloon), [[2, 0, 1]]);
});

test("the grid tells what is displayed and what draws apart from what is set", () => {
  const { board } = makeBoard();
  board.show({ robots: Uint8Array.of(4, 0), stations: Uint8Array.of(1) });
  assert.deepEqual([board.cell(0, 4).shown, board.cell(0, 1).shown, board.cell(1, 4).drawn, board.cell(2, 1)],
    [true, false, false, { on: true, shown: true, drawn: false, proposed: false, pending: false }]);
  assert.equal(board.shownByExpert, 2);
});

test("the countdown ends at the next snapshot and never runs over", () => {
  assert.deepEqual(countDown(60, 120, 120), { seconds: 2, share: 0.5 });
  assert.deepEqual(countDown(130, 120, 120), { seconds: 0, share: 0 });
  assert.deepEqual(countDown(-50, 120, 120), { seconds: 4, share: 1 });
});

test("the page says why no pairs are taken, the gravest reason first", () => {
  const fine = { connected: true, phase: "running", ended: false, lead: "a", recording: true, worker: /** @type {const} */ ("person") };
  assert.equal(whyNotRecording(fine), "");
  assert.equal(whyNotRecording({ ...fine, recording: false }), "the lead is away");
  assert.equal(whyNotRecording({ ...fine, lead: null }), "nobody has the lead");
  assert.equal(whyNotRecording({ ...fine, lead: undefined }), "starting");
  assert.equal(whyNotRecording({ ...fine, phase: "paused", lead: null }), "the worker is away");
  assert.equal(whyNotRecording({ ...fine, connected: false, phase: "paused" }), "no connection");
  assert.equal(whyNotRecording({ ...fine, connected: false, ended: true }), "the run has ended");
});

test("curves grow by what arrives, and a later word replaces an earlier one", () => {
  const book = new CurveBook();
  book.take({ from: 0, lines: { policy: { disable: [5, 4] }, arroch: { disable: [9, 9] } } });
  book.take({ from: 1, lines: { policy: { disable: [3, 2] } } });
  assert.deepEqual(book.named("disable").map(({ name }) => name), ["policy", "arroch"]);
  assert.deepEqual(book.table("disable", ["policy", "arroch"]), [[1, 2, 3], [5, 3, 2], [9, 9, null]]);
  book.take({ from: 4, lines: { policy: { disable: [1] } } });
  assert.deepEqual(book.table("disable", ["policy"])[1], [5, 3, 2, null, 1]);
  assert.deepEqual(new CurveBook().table("disable", []), [[]]);
});

test("robots' waits are counted from their beginning, or marked where it was not seen", () => {
  const times = new StateTimes();
  const at = (/** @type {number} */ state) => [{ state, x_m: 1, y_m: 1 }, { state: 3, x_m: 9, y_m: 9 }];
  times.take(0, at(2));
  times.take(30, at(3));
  times.take(120, at(3));
  assert.deepEqual([times.describe(0), times.describe(1), times.describe(7)], ["waiting 3 s", "waiting 4+ s", ""]);
  assert.deepEqual(countWaiting(at(3), [{ bays: [[1, 1.1], [2, 1]] }, { bays: [[5, 5]] }]), [1, 0]);
});

test("messages of the expert's socket are written as agreed and read strictly", () => {
  assert.equal(encodeExpertHello("00ff", 3), '{"type":"hello","version":1,"client":"00ff","last_seq":3}');
  assert.equal(encodeEdit(4, NOW, [[0, 4, 0]]), '{"type":"edit","seq":4,"trial":2,"tick":300,"changes":[[0,4,0]]}');
  assert.equal(encodeConfirm(5, NOW, [1, 2]), '{"type":"confirm","seq":5,"trial":2,"tick":300,"agents":[1,2]}');
  assert.deepEqual(decodeExpertText('{"type":"stored","seq":5}'), { type: "stored", seq: 5 });
  assert.deepEqual(decodeExpertText('{"type":"pong","sent_ms":1}'), { type: "pong", sent_ms: 1 });
  const broken = [
    "", "null", "7", '{"type":"stored"}', '{"type":"stored","seq":-1}', '{"type":"refused","seq":1}', '{"type":"curve","from":0,"lines":[]}',
    JSON.stringify({ type: "agents", ...agents({}), drawn: [1.5] }), '{"type":"experts","present":{}}', '{"type":"ballet"}',
  ];
  for (const text of broken) assert.throws(() => decodeExpertText(text), WireError, text);
});
