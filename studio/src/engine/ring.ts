// The last second of an action, row by row: always kept, so that it can be seen again as slowly as one likes.

/** Rows of f32 with their times; the newest overwrite the oldest. */
export class Ring {
  private readonly rows: Float32Array;
  private readonly times: Float64Array;
  private next = 0;
  private count = 0;

  constructor(readonly width: number, readonly capacity: number) {
    this.rows = new Float32Array(width * capacity);
    this.times = new Float64Array(capacity);
  }

  clear(): void {
    this.next = this.count = 0;
  }

  /** Room for the next row, which belongs to this time. */
  push(time: number): Float32Array {
    const at = this.next;
    this.times[at] = time;
    this.next = (at + 1) % this.capacity;
    this.count = Math.min(this.count + 1, this.capacity);
    return this.rows.subarray(at * this.width, (at + 1) * this.width);
  }

  get length(): number {
    return this.count;
  }

  /** Oldest and newest time, s; both 0 of an empty one. */
  get span(): [number, number] {
    return this.count ? [this.timeOf(0), this.timeOf(this.count - 1)] : [0, 0];
  }

  private place(index: number): number {
    return (this.next - this.count + index + this.capacity) % this.capacity;
  }

  timeOf(index: number): number {
    return this.times[this.place(index)]!;
  }

  row(index: number): Float32Array {
    const at = this.place(index);
    return this.rows.subarray(at * this.width, (at + 1) * this.width);
  }

  /** One number of a row. */
  at(index: number, column: number): number {
    return this.rows[this.place(index) * this.width + column]!;
  }

  /** The last row at or before a time, from 0, the oldest. */
  find(time: number): number {
    let low = 0, high = Math.max(this.count - 1, 0);
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.timeOf(middle) <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }
}
