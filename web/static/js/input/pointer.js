// Pointer lock: raw mouse motion where the browser offers it, plain lock where not.

/** Reports mouse motion while the pointer is locked to an element. */
export class PointerLock {
  /**
   * @param {HTMLElement} element that takes the lock
   * @param {{ motion: (dx_px: number, dy_px: number) => void, change: (locked: boolean) => void, refused: () => void }} handlers
   */
  constructor(element, handlers) {
    this.element = element;
    this.handlers = handlers;
    element.ownerDocument.addEventListener("pointerlockchange", () => handlers.change(this.isLocked));
    element.ownerDocument.addEventListener("pointerlockerror", () => handlers.refused());
    element.ownerDocument.addEventListener("mousemove", (event) => {
      if (this.isLocked) handlers.motion(event.movementX, event.movementY);
    });
  }

  get isLocked() {
    return this.element.ownerDocument.pointerLockElement === this.element;
  }

  /** Asks for the lock; must run inside a click or key handler. */
  async request() {
    if (this.isLocked) return;
    if (!this.element.requestPointerLock) {
      this.handlers.refused();
      return;
    }
    try {
      await this.element.requestPointerLock({ unadjustedMovement: true });
    } catch (error) {
      if (error instanceof DOMException && error.name === "NotSupportedError") await this.#requestPlain();
      else this.handlers.refused();
    }
  }

  async #requestPlain() {
    try {
      await this.element.requestPointerLock();
    } catch {
      this.handlers.refused();
    }
  }

  release() {
    if (this.isLocked) this.element.ownerDocument.exitPointerLock();
  }
}
