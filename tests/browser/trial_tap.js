// Listens to the trial page's sockets from outside: what the server said and what was sent.
// Kept as window.tap: sockets, welcomes, phases, the human's place by tick, and the displays.

(() => {
  const tap = { sockets: [], welcomes: [], phases: [], places: [], displays: [] };
  window.tap = tap;
  const hear = ({ data }) => {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      if (message.type === "welcome") tap.welcomes.push(message.tick);
      if (message.type === "phase") tap.phases.push(message.phase);
      return;
    }
    const view = new DataView(data);
    if (view.getUint8(0) === 4) tap.displays.push([...new Uint8Array(data)]);
    if (view.getUint8(0) !== 2) return;
    tap.places.push({
      tick: view.getUint32(2, true),
      x: view.getUint16(8, true) / 512,
      y: view.getUint16(10, true) / 512,
    });
  };
  window.WebSocket = class extends WebSocket {
    constructor(...options) {
      super(...options);
      tap.sockets.push(this);
      this.addEventListener("message", hear);
    }
  };
})();
