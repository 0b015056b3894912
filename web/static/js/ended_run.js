// The page of a learning run that is over: the curves and the agreement, as the server remembers them.

import { COLUMNS } from "./expert/board.js";
import { CurveBook, MEASURES } from "./expert/curves.js";
import { Connection } from "./net/connection.js";
import { decodeExpertText, encodeExpertHello } from "./net/expert_messages.js";
import { CurveChart } from "./ui/curve_chart.js";
import { People } from "./ui/people.js";

/** @param {Document} document @param {string} live address of the socket @param {string} client number of this page */
export function showEndedRun(document, live, client) {
  const place = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
  const curves = new CurveBook();
  const chart = new CurveChart(place("curves"), MEASURES, curves);
  const people = new People(place("people"), COLUMNS, { takeLead: () => {}, handOver: () => {} });
  people.showNobody();
  const connection = new Connection(
    live,
    {
      message: (message) => {
        if (message.type === "curve") {
          curves.take(message);
          chart.update();
        } else if (message.type === "agreement") people.showAgreement(message.experts);
        else if (message.type === "ended") connection.finish();
      },
      state: () => {},
    },
    { hello: () => encodeExpertHello(client, 0), decode: decodeExpertText, greeting: "run" },
  );
}
