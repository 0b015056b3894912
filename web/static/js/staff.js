// Entry of staff's pages: times in the viewer's own zone, and the live list.

import { LiveTable } from "./ui/live_table.js";
import { showOwnTimes } from "./ui/own_times.js";

showOwnTimes(document);
const table = document.getElementById("live-table");
if (table instanceof HTMLTableElement) new LiveTable(table);
