"""A second reader of MIDI files, for comparison: mido reads the events, this file pairs them.

    python second_reader.py generate > generated.tsv
    python second_reader.py packages FOLDER NOTES > packages.tsv

`generate` writes files of every kind and the notes that this reader finds in them; the crate's tests compare. `packages`
reads each MIDI file of the archives in FOLDER (sdists, wheels, npm packages) and the same file with NOTES, the program
that `cargo build --release -p erard-midi --example notes` makes; it writes a line for each file. It needs mido
(`pip install mido`).

The rules are those of `erard_midi::file::read`, written from its documentation and in another way: note-offs are matched
forward with a stack, strikes by trying every hold.
"""

import hashlib
import io
import random
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections import defaultdict
from pathlib import Path

import mido
from mido.midifiles import midifiles

build_meta_message = midifiles.build_meta_message


def timed(kind, data, delta=0):
    """mido 1.3.3 forgets the delay before a meta event that it does not know."""
    message = build_meta_message(kind, data, delta)
    message.time = delta
    return message


midifiles.build_meta_message = timed

LOWEST, KEYS, PERCUSSION = 21, 88, 9


def events(midi):
    """Messages as (tick, track, place, message), in the order of time."""
    found = []
    for number, track in enumerate(midi.tracks):
        tick = 0
        for place, message in enumerate(track):
            tick += message.time
            found.append((tick, number, place, message))
    return sorted(found, key=lambda one: one[:3])


def clock(division, all_events):
    """Seconds of a tick."""
    if division & 0x8000:
        frames = 256 - (division >> 8)
        rate = 30000 / 1001 if frames == 29 else frames
        return lambda tick: tick / (rate * (division & 0xFF))
    tempi = [(0, 500000)] + [(e[0], e[3].tempo) for e in all_events if e[3].type == "set_tempo" and e[3].tempo > 0]

    def seconds(tick):
        total = 0.0
        for (since, tempo), (until, _) in zip(tempi, tempi[1:] + [(float("inf"), 0)]):
            if tick > since:
                total += (min(tick, until) - since) * tempo * 1e-6 / division
        return total

    return seconds


def holds(touches):
    """Note-ons of a channel on a key with their ends: (on, velocity, off or None, release)."""
    by_tick = defaultdict(list)
    for tick, kind, value in touches:
        by_tick[tick].append((kind, value))
    stack, done = [], []
    for tick in sorted(by_tick):
        new = []
        for kind, value in by_tick[tick]:
            if kind == "on":
                new.append((tick, value))
            elif kind == "all":
                done += [(*hold, tick, None) for hold in stack]
                stack = []
            elif stack:
                done.append((*stack.pop(), tick, value))
            elif new:
                new.pop()
        stack += new
    return done + [(*hold, None, None) for hold in stack]


def read(data):
    """Notes as (key, start us, end us, velocity, release), velocities in 14 bits, release -1 where unknown."""
    midi = mido.MidiFile(file=io.BytesIO(data))
    all_events = events(midi)
    seconds = clock(int.from_bytes(data[12:14], "big"), all_events)
    last = max((e[0] for e in all_events), default=0)
    touches, prefix = defaultdict(list), {}
    for tick, track, _, message in all_events:
        if message.is_meta or not hasattr(message, "channel"):
            continue
        low = prefix.pop((track, message.channel), 0)
        if message.channel == PERCUSSION:
            if message.type == "control_change" and message.control == 88:
                prefix[track, message.channel] = message.value
            continue
        if message.type == "control_change":
            if message.control == 88:
                prefix[track, message.channel] = message.value
            elif message.control == 120 or message.control >= 123:
                for (key, channel), own in touches.items():
                    if channel == message.channel:
                        own.append((tick, "all", None))
        elif message.type in ("note_on", "note_off") and 0 <= message.note - LOWEST < KEYS:
            own = touches[message.note - LOWEST + 1, message.channel]
            if message.type == "note_on" and message.velocity > 0:
                own.append((tick, "on", message.velocity * 128 + low))
            else:
                unknown = message.type == "note_on" or (low == 0 and message.velocity in (0, 64))
                own.append((tick, "off", None if unknown else message.velocity * 128 + low))
    notes = []
    by_key = defaultdict(list)
    for (key, _), own in touches.items():
        by_key[key] += holds(own)
    us = lambda tick: round(1e6 * seconds(tick))
    for key, own in by_key.items():
        strikes = sorted({on for on, *_ in own})
        for on, after in zip(strikes, strikes[1:] + [None]):
            ends = [(off, release) for begun, _, off, release in own if begun <= on and off is not None and off > on]
            off, release = max(ends, key=lambda one: one[0], default=(None, None))
            ties = {r for o, r in ends if o == off}
            if after is not None and (off is None or off > after):
                off, ties = after, {None}
            end = last if off is None else off
            if us(end) > us(on) or seconds(end) > seconds(on):
                release = ties.pop() if len(ties) == 1 else None if off is None else "?"
                velocity = max(v for begun, v, *_ in own if begun == on)
                notes.append((key, us(on), us(end), velocity, -1 if release is None else release))
    return sorted(notes, key=lambda one: (one[1], one[0]))


def number(n):
    out = [n & 0x7F]
    while n > 0x7F:
        n >>= 7
        out.insert(0, n & 0x7F | 0x80)
    return bytes(out)


def smf(form, division, tracks):
    head = b"MThd" + (6).to_bytes(4, "big") + b"".join(x.to_bytes(2, "big") for x in (form, len(tracks), division))
    return head + b"".join(b"MTrk" + len(t).to_bytes(4, "big") + t for t in tracks)


def track(events, running=False):
    """Events (tick, bytes) as a track, with a running status where it is asked for."""
    out, now, status = b"", 0, None
    for tick, event in sorted(events, key=lambda one: one[0]):
        short = running and event[0] == status and event[0] < 0xF0
        out += number(tick - now) + (event[1:] if short else event)
        now, status = tick, event[0] if event[0] < 0xF0 else None
    return out + b"\0\xFF\x2F\0"


KINDS = ["plain", "tempi", "running", "legato", "voices", "counted", "empty", "controllers", "prefix", "other", "frames",
         "left out", "one of format 2"]
OTHER = [b"\xFF\x01\x03abc", b"\xFF\x54\x05\x60\0\x03\x0C\0", b"\xFF\x58\x04\x04\x02\x18\x08", b"\xFF\x59\x02\xFD\x01",
         b"\xFF\x7F\x02\x00\x41", b"\xFF\x20\x01\x03", b"\xFF\x21\x01\x00", b"\xFF\x60\x01\x00", b"\xF0\x03\x43\x12\xF7",
         b"\xF7\x01\x41", b"\xE0\x00\x40", b"\xD0\x40", b"\xA0\x3C\x40", b"\xC0\x30"]


def generated(kind, rng):
    division, form, tracks = rng.choice([24, 96, 480, 960]), 0, 1
    channels = [rng.randrange(16) for _ in range(rng.choice([1, 1, 3]))]
    channels = [c for c in channels if c != PERCUSSION] or [0]
    few = [rng.randrange(LOWEST, LOWEST + KEYS) for _ in range(3)]
    if kind in ("tempi", "voices", "counted"):
        form, tracks = 1, rng.randrange(2, 4)
    own_events = [[] for _ in range(tracks)]
    for _ in range(rng.randrange(1, 14)):
        own, channel, key = rng.choice(own_events), rng.choice(channels), rng.choice(few)
        on = rng.randrange(12) * division // 4
        off = on + rng.randrange(1, 6) * division // 4
        if kind == "left out":
            channel, key = rng.choice([channel, PERCUSSION]), rng.choice([key, 20, 109, 0, 127])
        down = bytes([0x90 | channel, key, rng.randrange(1, 128)])
        up = bytes([rng.choice([0x80, 0x90]) | channel, key, rng.choice([0, 0, 64, rng.randrange(128)])])
        if up[0] >= 0x90:
            up = up[:2] + b"\0"
        if kind == "prefix" and rng.random() < 0.7:
            down = (bytes([0xB0 | channel, 88, rng.randrange(128)]), down)
        for event in down if isinstance(down, tuple) else (down,):
            own.append((on, event))
        if kind == "legato":
            own += rng.sample([(off, up), (off, down)], 2)
            off += division // 2
        if kind == "empty" and rng.random() < 0.4:
            off = on
        if not (kind == "counted" and rng.random() < 0.3):
            own.append((off, up))
        if kind == "counted" and rng.random() < 0.2:
            own.append((off + division // 4, up))
        if kind == "controllers" and rng.random() < 0.5:
            own.append((rng.randrange(60) * division // 20,
                        bytes([0xB0 | channel, rng.choice([64, 66, 67, 120, 121, 123, 124, 127, 1]), rng.randrange(128)])))
        if kind == "other":
            own.append((rng.randrange(60) * division // 20, rng.choice(OTHER)))
    if kind == "tempi":
        for _ in range(rng.randrange(1, 5)):
            tempo = rng.randrange(200_000, 1_500_000).to_bytes(3, "big")
            rng.choice(own_events).append((rng.randrange(60) * division // 20, b"\xFF\x51\x03" + tempo))
    if kind == "frames":
        division = (256 - rng.choice([24, 25, 29, 30])) << 8 | rng.choice([4, 40, 100])
    if kind == "one of format 2":
        form = 2
    return smf(form, division, [track(own, kind == "running" or rng.random() < 0.2) for own in own_events])


def generate():
    rng = random.Random(61)
    print("# kind, file, and its notes: key, start and end, us, velocity and release, 14 bits (-1: unknown)")
    print("# second_reader.py generate; mido", mido.version_info)
    for _ in range(15):
        for kind in KINDS:
            data = generated(kind, rng)
            print(kind, data.hex(), " ".join(",".join(map(str, note)) for note in read(data)), sep="\t")


def files(folder):
    """Each MIDI file of the archives in a folder: archive, name, bytes."""
    for path in sorted(Path(folder).iterdir()):
        if path.name.endswith((".tar.gz", ".tgz")):
            with tarfile.open(path) as archive:
                inside = [(m.name, archive.extractfile(m).read()) for m in archive if m.isfile() and is_midi(m.name)]
        elif path.suffix in (".whl", ".zip"):
            with zipfile.ZipFile(path) as archive:
                inside = [(name, archive.read(name)) for name in archive.namelist() if is_midi(name)]
        else:
            continue
        for name, data in sorted(inside):
            yield path.name, name, data


def is_midi(name):
    return name.lower().endswith((".mid", ".midi", ".kar", ".rmi")) and "/." not in name


def packages(folder, program):
    print("package\tfile\tsha256\tbytes\tnotes\tsecond_reader\tdiffer\twhy")
    seen = set()
    for package, name, data in files(folder):
        digest = hashlib.sha256(data).hexdigest()
        if digest in seen:
            continue
        seen.add(digest)
        with tempfile.NamedTemporaryFile(suffix=".mid") as file:
            file.write(data)
            file.flush()
            said = subprocess.run([program, file.name], capture_output=True, text=True, check=False)
        own = [tuple(map(float, line.split(","))) for line in said.stdout.splitlines() if line[0].isdigit()]
        remarks = [line[2:] for line in said.stdout.splitlines() if line.startswith("# ")]
        try:
            other, fault = read(data), ""
        except Exception as error:  # whatever mido refuses it with
            other, fault = None, f"mido: {type(error).__name__}: {error}"
        if said.returncode:
            fault = "; ".join(filter(None, [fault, "erard: " + said.stderr.strip().split("\n")[0].replace(file.name, "file")]))
        differ = "" if other is None or said.returncode else sum(not alike(a, b) for a, b in zip(own, other)) + abs(len(own) - len(other))
        why = fault or ("; ".join(remarks) if differ else "")
        counts = [len(own) if not said.returncode else "", "" if other is None else len(other), differ]
        print(package, name, digest, len(data), *counts, " ".join(why.split()), sep="\t")


def alike(own, other):
    near = abs(own[1] - other[1]) <= 1 and abs(own[2] - other[2]) <= 1
    return near and own[0] == other[0] and own[3] == other[3] and (own[4] == other[4] or other[4] == "?")


if __name__ == "__main__":
    if sys.argv[1:] == ["generate"]:
        generate()
    elif sys.argv[1:2] == ["packages"] and len(sys.argv) == 4:
        packages(*sys.argv[2:])
    else:
        sys.exit(__doc__)
