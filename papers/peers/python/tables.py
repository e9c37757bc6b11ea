"""The comparison as Markdown and CSV."""

import csv
import io

from comparison import EQUAL_ERRORS


def table(head, rows):
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def seconds(value):
    return f"{value * 1e3:.3g} ms"


def markdown(comparison, machine):
    """The report that people read."""
    blows, speeds = len(comparison.reference), list(comparison.reference.values())
    text = [
        "# The same action in other programs",
        "",
        "Written by `papers/peers/run`; what is compared and how stands in `papers/peers/README.md`.",
        "",
    ]
    text += [f"- {key}: {value}" for key, value in machine.items()]
    text += [
        f"- the action: {comparison.instrument}, {comparison.bodies} bodies",
        f"- the blows: mf, its force times {blows} factors; hammer speeds {min(speeds):.4f} to {max(speeds):.4f} m/s; "
        f"{comparison.until_s * 1e3:g} ms each; times are the least of some repetitions of each blow, the median of the blows",
        f"- the reference: Erard's engine at a step of {comparison.reference_step_s * 1e6:.3g} us",
        "",
        "## That it is the same action",
        "",
        "Accelerations of the same states by separately written equations, largest relative difference to diffsol's:",
        "",
        table(["program", "difference"], [[peer, f"{found:.1e}"] for peer, found in comparison.agreement.items()]),
        "Mean relative difference of diffsol's hammer speeds to the reference as its friction law gets sharper:",
        "",
        table(
            ["width, rad/s", "tolerance", "difference"],
            [
                [f"{p['width_rad_per_s']:g}", f"{p['tolerance']:g}", p.get("failed") or f"{p['mean_error']:+.2e}"]
                for p in comparison.limit
            ],
        ),
    ]
    for error in EQUAL_ERRORS:
        text += [
            f"## At a hammer-speed error of at most {error:g}",
            "",
            "Each with its fastest setting of those tried.",
            "",
        ]
        rows = []
        for peer, (point, ratio) in comparison.at_error(error).items():
            if point is None:
                rows.append([peer, "not reached", "", "", "", ""])
            else:
                rows.append(
                    [
                        peer,
                        point["setting"],
                        f"{point['error']:.1e}",
                        seconds(point["seconds"]),
                        f"{point['real_time_factor']:.3g}",
                        f"{ratio:.3g}" if ratio else "",
                    ]
                )
        text.append(table(["program", "setting", "error", "time", "times real time", "time over Erard's"], rows))
    text += [
        "## Targets",
        "",
        targets(comparison.targets()),
        "## A hammer held in check",
        "",
        held(comparison),
    ]
    text += ["## Every setting", "", everything(comparison)]
    return "\n".join(text)


def targets(found):
    """Wanted and measured, met or not."""
    if found is None:
        return "No peer reached the target's error.\n"
    verdict = lambda met: "met" if met else "NOT met"
    between = lambda one: f" ({one['least']:.3g} to {one['largest']:.3g})" if "least" in one else ""
    lines = [
        f"- At an error of {found['error']:g} the fastest peer ({found['fastest_peer']}) takes {found['ratio']:.3g}{between(found)} times Erard's time; "
        f"wanted {found['ratio_wanted']:g}: {verdict(found['ratio_met'])}."
    ]
    for batch in found["batches"]:
        lines.append(
            f"- Of a batch ({batch['batch']}) it takes {batch['ratio']:.3g}{between(batch)} times Erard's time for each blow; "
            f"wanted {batch['ratio_wanted']:g}: {verdict(batch['ratio_met'])}."
        )
    if "rounds" in found:
        lines.append(f"\nEach timed right after the other in {found['rounds']} rounds; Erard with {found['setting']}. The median of the rounds, and in brackets the least and the largest.")
    return "\n".join(lines) + "\n"


def held(comparison):
    hold, rows = comparison.hold, []
    for h in comparison.holds:
        if "failed" in h:
            rows.append([h["name"], h["setting"], h["failed"], "", "", "", ""])
        else:
            rows.append(
                [
                    h["name"],
                    h["setting"],
                    f"{h['drift_rad']:.1e}",
                    f"{h['drift_mm']:.2g}",
                    f"{h['off_caught_rad']:+.1e}",
                    seconds(h["seconds"]),
                    f"{h['real_time_factor']:.3g}",
                ]
            )
    about = [
        f"A constant {hold['force_N']:g} N from rest. Drift: the largest departure of the hammer's angle between {hold['from_s']:g} and",
        f"{hold['until_s']:g} s, and what that is at the strike point. Off: its angle at the end minus the angle in which Erard's engine,",
        "at its finest step here, holds it. A hammer that slipped out of the check before the first second drifts little more, and",
        "is far off.",
    ]
    return (
        "\n".join(about)
        + "\n\n"
        + table(["program", "setting", "drift, rad", "drift, mm", "off, rad", "time", "times real time"], rows)
    )


def everything(comparison):
    rows = []
    for p in comparison.points:
        if "failed" in p:
            rows.append([p["name"], p["setting"], p["failed"], "", "", "", ""])
        else:
            own = f"{p['callback_seconds'] / p['seconds']:.0%}" if "callback_seconds" in p else ""
            rows.append(
                [
                    p["name"],
                    p["setting"],
                    f"{p['error']:.1e}",
                    f"{p['worst_error']:.1e}",
                    seconds(p["seconds"]),
                    f"{p['real_time_factor']:.3g}",
                    own,
                ]
            )
    head = ["program", "setting", "error, rms", "error, worst", "time", "times real time", "of it in the callback"]
    return table(head, rows)


COLUMNS = [
    "name",
    "step_s",
    "newton_tolerance",
    "tolerance",
    "width_rad_per_s",
    "error",
    "worst_error",
    "seconds",
    "callback_seconds",
    "real_time_factor",
    "steps",
    "evaluations",
    "failed",
]


def points_csv(comparison):
    """Every point, one line each."""
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(comparison.points)
    return out.getvalue()
