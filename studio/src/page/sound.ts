// Sound: a keyboard in the browser's audio thread, notes rendered before they are heard, and why there is silence.
// Loaded when it is asked for.
import { type FromKeys, FULL_SCALE, type Note, SOUND_STEP_S, type ToKeys } from "../engine/protocol";
import type { Options } from "../engine/sound.worklet";
import worklet from "../engine/sound.worklet.ts?worker&url";

/** The rate that is asked for, Hz: two samples are a step of the usual length. */
const RATE_HZ = 48_000;
/** A browser that has not begun to sound after so long does not, ms. */
const PATIENCE_MS = 2000;
/** Silence between two notes, and how a note ends, s. */
const PAUSE_S = 0.4, FADE_S = 0.05;

/** Something that sounds, or has sounded. */
export interface Speaker {
  tell(message: ToKeys): void;
  end(): void;
}

/** A context that sounds; begun by a gesture, or refused with the reason. */
const begun = async (options: AudioContextOptions): Promise<AudioContext> => {
  if (typeof AudioContext !== "function") throw new Error("this browser has no Web Audio");
  const context = new AudioContext(options);
  await Promise.race([context.resume(), new Promise((resolve) => setTimeout(resolve, PATIENCE_MS))]);
  if (context.state === "running") return context;
  void context.close();
  throw new Error("the browser does not let this page sound: allow sound for it, and see that the machine has an output");
};

/** A processor with a keyboard of its own, in a context that may also render faster than it is heard. */
export const keysNode = async (context: BaseAudioContext, options: Options): Promise<AudioWorkletNode> => {
  if (!context.audioWorklet) throw new Error("browsers give pages the audio thread over https, or from this machine, only");
  await context.audioWorklet.addModule(worklet);
  const node = new AudioWorkletNode(context, "erard-keys", { numberOfInputs: 0, outputChannelCount: [2], processorOptions: options });
  node.connect(context.destination);
  return node;
};

/** A built-in keyboard that is heard. `hear` receives what it says. */
export const speaker = async (module: WebAssembly.Module, name: string, hear: (message: FromKeys) => void): Promise<Speaker> => {
  const context = await begun({ sampleRate: RATE_HZ, latencyHint: "interactive" });
  try {
    const node = await keysNode(context, { module, name, turns: [], exact: false });
    node.port.onmessage = ({ data }: MessageEvent<FromKeys>) => hear(data);
    node.onprocessorerror = () => hear({ kind: "fault", message: "the audio thread has failed" });
    return { tell: (message) => node.port.postMessage(message), end: () => void context.close() };
  } catch (error) {
    void context.close();
    throw error;
  }
};

/** For tests: a passage as the audio thread plays it, faster than it is heard: samples at 48 kHz of a full scale of 1,
 * left and right. */
export const rendered = async (module: WebAssembly.Module, name: string, turns: [number, number, number][], seconds: number, exact: boolean): Promise<Float32Array[]> => {
  const context = new OfflineAudioContext(2, Math.round(seconds * RATE_HZ), RATE_HZ);
  await keysNode(context, { module, name, turns, exact });
  const buffer = await context.startRendering();
  return [0, 1].map((channel) => buffer.getChannelData(channel));
};

let playing: AudioContext | null = null;
/** Notes, as the workshop renders them, one after the other; what was played before ends. @returns once the first one
 * begins. */
export const play = async (notes: Note[]): Promise<void> => {
  void playing?.close();
  playing = null;
  const context = (playing = await begun({}));
  let at_s = context.currentTime + 0.05;
  const over = notes.map((note) => new Promise<void>((resolve) => {
    const buffer = context.createBuffer(2, note.bridge_n.length, 1 / SOUND_STEP_S), source = new AudioBufferSourceNode(context, { buffer });
    const scale = 1 / FULL_SCALE[note.unit], gain = new GainNode(context, { gain: scale });
    note.channels.forEach((samples, channel) => buffer.copyToChannel(samples, channel));
    gain.gain.setValueAtTime(scale, at_s + buffer.duration - FADE_S);
    gain.gain.linearRampToValueAtTime(0, at_s + buffer.duration);
    source.connect(gain).connect(context.destination);
    source.start(at_s);
    source.onended = () => resolve();
    at_s += buffer.duration + PAUSE_S;
  }));
  void Promise.all(over).then(() => {
    if (playing === context) playing = null;
    void context.close();
  });
};
