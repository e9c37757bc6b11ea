// The workers that take their time: one for what is asked while sliders move, a few for what is measured. What is not
// wanted any more is ended.
import type { FromWorkshop, Task } from "../engine/protocol";

interface Waiting {
  task: Task;
  group: string | null;
  resolve(answer: unknown): void;
  reject(error: Error): void;
}

/** Thrown to whoever waits for what is not wanted any more. */
export class Dropped extends Error {}

class Hand {
  private worker: Worker | null = null;
  private ready = false;
  private now: Waiting | null = null;
  private id = 0;

  /** @param early whether it starts at once, and not with its first task: the page's beginning waits for one hand
   * only. */
  constructor(private readonly module: WebAssembly.Module, private readonly next: () => Waiting | undefined, early: boolean) {
    if (early) this.start();
  }

  private start(): void {
    this.ready = false;
    this.worker = new Worker(new URL("../engine/workshop.worker.ts", import.meta.url), { type: "module" });
    this.worker.onmessage = ({ data }: MessageEvent<FromWorkshop>) => {
      if (data.kind === "ready") this.ready = true;
      else if (this.now && data.id === this.id) {
        const { resolve, reject } = this.now;
        this.now = null;
        if (data.kind === "done") resolve(data.answer);
        else reject(new Error(data.message));
        // A library that has failed is not used again.
        if (data.kind === "failed" && data.fault) this.restart();
      }
      this.go();
    };
    this.worker.onerror = () => {
      this.now?.reject(new Error("the workshop failed"));
      this.now = null;
      this.restart();
    };
    this.worker.postMessage({ kind: "open", module: this.module });
  }

  private restart(): void {
    this.worker?.terminate();
    this.start();
  }

  go(): void {
    if (!this.worker) this.start();
    if (!this.ready || this.now) return;
    const next = this.next();
    if (!next) return;
    this.now = next;
    this.id += 1;
    this.worker!.postMessage({ kind: "task", id: this.id, task: next.task });
  }

  drop(group: string): void {
    if (this.now?.group !== group) return;
    this.now.reject(new Dropped());
    this.now = null;
    this.restart();
  }
}

export class Bench {
  private readonly quick: Waiting[] = [];
  private readonly slow: Waiting[] = [];
  private readonly quickHand: Hand;
  private readonly slowHands: Hand[];

  constructor(module: WebAssembly.Module) {
    this.quickHand = new Hand(module, () => this.quick.shift(), true);
    const hands = Math.min(Math.max((navigator.hardwareConcurrency || 2) - 1, 1), 3);
    this.slowHands = Array.from({ length: hands }, () => new Hand(module, () => this.slow.shift(), false));
  }

  /** Asks for something; what belongs to a group takes its time, and can be dropped. */
  ask<T>(task: Task, group: string | null = null): Promise<T> {
    return new Promise<T>((resolve, reject) => {
      const waiting: Waiting = { task, group, resolve: resolve as (answer: unknown) => void, reject };
      if (group === null) {
        this.quick.push(waiting);
        this.quickHand.go();
      } else {
        this.slow.push(waiting);
        this.slowHands.forEach((hand) => hand.go());
      }
    });
  }

  drop(group: string): void {
    for (let n = this.slow.length - 1; n >= 0; n--) {
      if (this.slow[n]!.group === group) this.slow.splice(n, 1)[0]!.reject(new Dropped());
    }
    for (const hand of this.slowHands) hand.drop(group);
  }
}
