#!/usr/bin/env python3
"""Draws the moving picture of the README: one note of the concert grand, slowed, as one SVG file.

    docs/moving.py [--erard COMMAND] FILE.svg

`erard draw --at MILLISECONDS` draws each pose. All poses consist of the same shapes: only the places and angles of the
bodies differ. So the file is the first pose with a CSS animation for each body, and moves wherever a browser shows it,
as a picture, too. For readers who ask their system for less motion it stands still.
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

#: Parts of the note: from and to, ms; ms between poses; how many times slower than it is.
STAGES = [(16, 52, 3, 30), (52, 80, 0.5, 80), (80, 104, 2, 30), (504, 740, 4, 10)]
#: Seconds for which the picture stands still after a stage.
PAUSES = [0, 0, 0.8, 0.6]
#: Seconds of the jump over the time in which the key is held.
JUMP_S = 0.01

TAG = re.compile(r"<[^>]*>[^<]*")
TRANSFORM = re.compile(r' transform="translate\(([-\d.]+) ([-\d.]+)\) rotate\(([-\d.]+)\)"')


def pose(erard, folder, at_ms):
    """The tags of the action's drawing at an instant."""
    command = [erard, "draw", "--at", f"{at_ms:g}", "--out", folder, "--force", "--quiet"]
    subprocess.run(command, check=True)
    text = (Path(folder) / "action.svg").read_text(encoding="utf-8")
    # What made it names a commit, which a picture that is kept does not.
    return TAG.findall(re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.S))


def timeline():
    """Instants of the poses, ms; when each is shown, s; begin and end of each stage, s; the whole length, s."""
    poses, shown, stages, now = [], [], [], 0.0
    for (begin, end, step, slower), pause in zip(STAGES, PAUSES):
        count = round((end - begin) / step)
        began = now
        for i in range(count + 1):
            if i == 0 and poses and poses[-1] == begin:
                continue
            if i == 0 and poses:
                now += JUMP_S
            at = begin + (end - begin) * i / count
            poses.append(at)
            shown.append(now + (at - begin) * slower * 1e-3)
        now += (end - begin) * slower * 1e-3 + pause
        if pause:
            poses.append(end)
            shown.append(now)
        stages.append((began, now))
    return poses, shown, stages, now


def short(number):
    """A number in hundredths, as short as CSS takes it."""
    text = f"{float(number):.2f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else re.sub(r"^(-?)0\.", r"\1.", text)


def animated(frames, shown, length_s):
    """The first pose with classes, and the style that moves it."""
    series, tags, style = {}, [], []
    for i, first in enumerate(frames[0]):
        places = [TRANSFORM.search(frame[i]) for frame in frames]
        if not places[0] or len({place.groups() for place in places}) == 1:
            tags.append(first)
            continue
        moves = tuple(place.groups() for place in places)
        name = series.setdefault(moves, f"m{len(series)}")
        tag, end = re.subn(r"^<(\w+)", rf'<\1 class="{name}"', first, count=1)
        if not end or ' class="' in first:
            raise SystemExit(f"error: docs/moving.py: expected a tag without a class, found {first[:60]}")
        tags.append(tag)
    for moves, name in series.items():
        keys, last = [], None
        for n, (moved, at) in enumerate(zip(moves, shown)):
            x, y, angle = map(short, moved)
            rule = f"transform:translate({x}px,{y}px)rotate({angle}deg)"
            ahead = tuple(map(short, moves[n + 1])) if n + 1 < len(moves) else None
            # A pose that is the same as the one before and after it says nothing.
            if rule != last or ahead != (x, y, angle):
                keys.append(f"{short(100 * at / length_s)}%{{{rule}}}")
            last = rule
        style.append(f".{name}{{animation:{name} {length_s:g}s linear infinite}}@keyframes {name}{{{''.join(keys)}}}")
    return tags, style


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--erard", default="target/release/erard")
    parser.add_argument("file", type=Path)
    arguments = parser.parse_args()
    poses, shown, stages, length_s = timeline()
    length_s = round(length_s, 2)
    with tempfile.TemporaryDirectory() as folder:
        drawn = {at: pose(arguments.erard, folder, at) for at in sorted(set(poses))}
    frames = [drawn[at] for at in poses]
    views = []
    for frame in frames:
        views.append([float(part) for part in re.search(r'viewBox="([^"]*)"', frame[0])[1].split()])
        for one, other in zip(frame[1:], frames[0][1:], strict=True):
            # The paper and the caption are written anew.
            if TRANSFORM.sub("", one) != TRANSFORM.sub("", other) and 'class="paper"' not in one and 'class="caption"' not in one:
                raise SystemExit(f"error: docs/moving.py: expected poses that differ by their transforms, found {one[:60]}")
    left, top = (min(view[i] for view in views) for i in (0, 1))
    width = max(view[0] + view[2] for view in views) - left
    height = max(view[1] + view[3] for view in views) - top
    tags, style = animated(frames, shown, length_s)
    head = re.sub(r'viewBox="[^"]*"', f'viewBox="{left:g} {top:g} {width:g} {height:g}"', tags[0])
    tags[0] = re.sub(r'height="\d+"', f'height="{round(1400 * height / width)}"', head, count=1)
    captions = []
    for n, ((begin, end), (*_, slower)) in enumerate(zip(stages, STAGES)):
        on, off = short(100 * begin / length_s), short(100 * end / length_s)
        first = "" if n == 0 else f"0%,{on}%{{opacity:0}}"
        style.append(f".t{n}{{opacity:0;animation:t{n} {length_s:g}s step-end infinite}}@keyframes t{n}{{{first}{on}%{{opacity:1}}{off}%,to{{opacity:0}}}}")
        captions.append(f'<text class="caption t{n}" x="{left + 6:g}" y="{top + height - 7:g}">One note, mf, {slower} times slower than it is</text>')
    for i, tag in enumerate(tags):
        if 'class="paper"' in tag:
            tags[i] = f'<rect class="paper" x="{left:g}" y="{top:g}" width="{width:g}" height="{height:g}"/>'
        elif 'class="caption"' in tag:
            # The end of the drawing's own caption closes the last one.
            tags[i] = "".join(captions).removesuffix("</text>")
    style.append("@media (prefers-reduced-motion:reduce){*{animation:none!important}.t0{opacity:1}}")
    text = "".join(tags).replace("</style>", "\n".join(["", *style]) + "</style>", 1)
    arguments.file.write_text(text, encoding="utf-8")
    print(f"{arguments.file}: {len(frames)} poses, {length_s:g} s, {len(text.encode()) / 1000:.0f} kB")


if __name__ == "__main__":
    main()
