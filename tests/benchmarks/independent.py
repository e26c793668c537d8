"""Drops of a simulator that shares no line with the program, against their truth: is it right, or does it say so.

python3 packaging/dev.py bench independent [-n 20] [--seed S] [--correction flights] [--first K] [--only K ...]
python3 packaging/dev.py bench independent --only 3 --hold polarization_off=0 floor=none   one effect at a time
python3 packaging/dev.py bench independent --ideal                   nothing but geometry: both must agree exactly
python3 packaging/dev.py bench independent --rows FILE               add rows to a file; --table FILE prints one

off: a number (e of the first impact, shape of the track, place) is farther than 4 u from the truth, shape and place by
the combined u of the place; the u beside the shape is the one with the setup held. right: nothing is off; told:
something is, and it warns; SILENT: something is and nothing is said; wrong cause: a warning names entries of the
setup that all lie within 2 u of their true values; refused: no result stands.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from benchmarks import _independent_world as world

import radargui
from radargui.model.recording import Digitisation

LIMIT_S = 300.0
NAMED = re.compile(r"receiver\[\d\]|transmitter|tracer\.\w+")
PLATES = {
    "none": None,
    "acrylic": world.Plate(1.61, 0.010, 1.0),
    "acrylic on wood": world.Plate(1.61, 0.010, 1.5),
    "glass": world.Plate(2.55, 0.010, 1.0),
    "granite": world.Plate(2.45, 0.030, 1.0),
    "steel": world.Plate(None),
}
CHANCE = {"none": 0.15, "acrylic": 0.25, "acrylic on wood": 0.15, "glass": 0.15, "granite": 0.15, "steel": 0.15}


@dataclass
class Scene:
    """What was drawn: the setup as stated, the world as it is, how it is digitised."""

    stated: dict
    room: world.Room
    motion: world.Motion
    raw: np.ndarray
    scaling: float
    off_u: dict
    """By how many of its u each entry of the setup is off."""
    drawn: dict


def draw(seed, number, hold, ideal):
    """Return all that is random of a scene, in a fixed order, so that what is held changes nothing else."""
    rng = np.random.default_rng([seed, number])
    uniform, normal = rng.uniform, rng.standard_normal
    drawn = {
        "exact": bool(uniform() < 0.4),
        "tx_m": round(uniform(0.5, 0.9), 3),
        "rx_m": [round(one, 3) for one in uniform(0.55, 0.9, 3)],
        "tilt": [round(one, 1) for one in uniform(32, 50, 3)],
        "azimuth": [round(float(90 + 120 * i + one), 1) for i, one in enumerate(uniform(-8, 8, 3))],
        "polarization": float(rng.choice([0.0, 45.0, 90.0, round(uniform(0, 180), 1)])),
        "turned": bool(uniform() < 0.7),
        "diameter": float(rng.choice([5e-3, 6e-3, 8e-3, 10e-3, 12e-3])),
        "release": [round(one, 4) for one in (*uniform(-0.01, 0.01, 2), uniform(0.05, 0.14))],
        "height": uniform(0.10, 0.32),
        "e": uniform(0.35, 0.93),
        "e_slope": float(rng.choice([0.0, 0.04, 0.1])),
        "scatter": float(rng.choice([0.0, 0.003, 0.01])),
        "kick": float(rng.choice([0.0, 0.01, 0.02])),
        "air": 1.0,
        "sideways": list(0.006 * normal(2)),
        "lean_deg": uniform(0.0, 0.2),
        "lean_azimuth": uniform(0, 360),
        "floor": str(rng.choice(list(CHANCE), p=list(CHANCE.values()))),
        "floor_stated": bool(uniform() < 0.5),
        "exchange": True,
        "wall": bool(uniform() < 0.35),
        "wall_at": [uniform(0.6, 1.2), uniform(0, 360), uniform(0.02, 0.1)],
        "lobe_deg": uniform(20, 45),
        "rate": float(rng.choice([10000.0, 20000.0, 33333.0])),
        "multiplexed": bool(uniform() < 0.8),
        "snr_db": uniform(30, 45),
        "amplitude": list(uniform(0.6, 2.0, 3)),
        "phase": list(uniform(0, 2 * np.pi, 3)),
        "gain": list(1 + 0.04 * normal(3)),
        "quadrature_deg": list(2.5 * normal(3)),
        "offset": [list(one) for one in 0.2 * normal((3, 2))],
        "crosstalk": float(rng.choice([0.0, 0.001, 0.002])),
        "sign": int(rng.choice([1, -1])),
        "u_angle": round(uniform(0.1, 0.5), 2),
        "u_m": round(uniform(1e-3, 4e-3), 4),
        "u_turn": round(uniform(1.0, 5.0), 1),
        "u_release": round(uniform(0.3e-3, 1.0e-3), 5),
        "u_diameter": 1e-5,
        "quantised": True,
    }
    deviates = {
        name: normal(size)
        for name, size in {"tilt": 3, "azimuth": 3, "distance": 4, "beside": 2, "turn": 4, "release": 3}.items()
    }
    deviates |= {"diameter": normal(1), "clock": normal(1), "gravity": normal(1), "contact": normal(1)}
    scale = 0.0 if drawn["exact"] else 1.0
    drawn |= {"antennas_off": scale, "polarization_off": scale, "release_off": scale, "rest_off": scale}
    if ideal:
        drawn |= {"exact": True, "floor": "none", "wall": False, "snr_db": 60.0, "crosstalk": 0.0, "scatter": 0.0}
        drawn |= {"gain": [1.0] * 3, "quadrature_deg": [0.0] * 3, "offset": [[0.0, 0.0]] * 3, "quantised": False}
        drawn |= {"antennas_off": 0.0, "polarization_off": 0.0, "release_off": 0.0, "rest_off": 0.0}
    unknown = set(hold) - set(drawn)
    if unknown:
        raise SystemExit(f"nothing drawn is called {', '.join(unknown)}: {', '.join(drawn)}")
    return drawn | hold, deviates, rng


def towards(tilt_deg, azimuth_deg):
    """Return the direction from the origin to a receiver."""
    tilt, azimuth = np.radians([tilt_deg, azimuth_deg])
    return np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])


def across(direction):
    """Return h and v, what a receiver's polarisation counts from."""
    h = world.unit(np.cross([0.0, 0.0, 1.0], direction))
    return h, np.cross(direction, h)


def receiver_angle(drawn, place, electric, sphere):
    """Return the stated polarisation of a receiver: for the strongest signal, or level or upright."""
    direction = world.unit(place)
    out = sphere.answered(*sphere.excited(np.array([[0.0, 0.0, -1.0]]), electric[None]))
    seen = sphere.sent(out, direction[None])[0]
    h, v = across(direction)
    best = world.strongest(seen, direction)
    if not drawn["turned"]:
        level, upright = abs(seen @ h), abs(seen @ v)
        return 0.0 if level > upright else 90.0
    return round(float(np.degrees(np.arctan2(best @ v, best @ h)) % 180), 1)


def electric_of(angle_deg):
    """Return the transmitter's field."""
    return np.array([np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg)), 0.0])


def build(seed, number, hold, ideal=False):
    """Return a whole scene."""
    drawn, deviates, rng = draw(seed, number, hold, ideal)
    index, frequency = 1.00032, 1e10
    k = 2 * np.pi * frequency * index / world.LIGHT_M_S
    u_angle, u_m, u_turn = drawn["u_angle"], drawn["u_m"], drawn["u_turn"]
    stated_electric = electric_of(drawn["polarization"])
    sphere = world.Sphere(drawn["diameter"] / 2, k)
    angles = [
        receiver_angle(drawn, towards(*one), stated_electric, sphere)
        for one in zip(drawn["tilt"], drawn["azimuth"], strict=True)
    ]
    off = {name: drawn["antennas_off"] * deviates[name] for name in ("tilt", "azimuth", "distance", "beside")}
    off["turn"] = drawn["polarization_off"] * deviates["turn"]
    off["release"] = drawn["release_off"] * deviates["release"]
    off["diameter"], off["clock"], off["gravity"], off["contact"] = (
        drawn["rest_off"] * deviates[name] for name in ("diameter", "clock", "gravity", "contact")
    )
    beside = u_m * off["beside"]
    sender = world.Antenna(
        np.array([*beside, drawn["tx_m"] + u_m * off["distance"][3]]),
        electric_of(drawn["polarization"] + u_turn * off["turn"][3]),
        drawn["lobe_deg"],
    )
    receivers = []
    for i in range(3):
        direction = towards(
            drawn["tilt"][i] + u_angle * off["tilt"][i], drawn["azimuth"][i] + u_angle * off["azimuth"][i]
        )
        h, v = across(direction)
        turn = np.radians(angles[i] + u_turn * off["turn"][i])
        place = (drawn["rx_m"][i] + u_m * off["distance"][i]) * direction
        receivers.append(world.Antenna(place, np.cos(turn) * h + np.sin(turn) * v, drawn["lobe_deg"]))
    release = np.array(drawn["release"]) + drawn["u_release"] * off["release"]
    diameter = drawn["diameter"] + drawn["u_diameter"] * off["diameter"][0]
    normal = towards(drawn["lean_deg"], drawn["lean_azimuth"])
    contact = drawn["release"][2] - drawn["height"]
    touch = np.array([0.0, 0.0, contact])
    gravity = 9.81 + 0.0005 * off["gravity"][0]

    def bounce(velocity, n):
        before = -velocity @ n
        e = min(drawn["e"] * max(before, 0.05) ** -drawn["e_slope"], 0.96) * (
            1 + drawn["scatter"] * rng.standard_normal()
        )
        level = velocity + before * n
        kick = drawn["kick"] * rng.standard_normal(3)
        return 0.95 * level + kick - (kick @ n) * n + e * before * n

    start, seconds = 0.7, 3.0
    motion = world.drop(
        release,
        [*drawn["sideways"], 0.0],
        start,
        start + seconds + 0.1,
        touch,
        normal,
        gravity,
        diameter,
        7800.0,
        bounce,
        drawn["air"],
    )
    end = min(motion.pieces[-1].begin + 0.6, start + seconds)
    plate = PLATES[drawn["floor"]]
    room = world.Room(
        k, diameter / 2, sender, receivers, plate,
        surface=(touch @ normal - diameter / 2) / normal[2], normal=normal,
        walls=[world.Wall(*drawn["wall_at"])] if drawn["wall"] else [],
        exchange=bool(drawn["exchange"]) and drawn["floor"] in ("steel", "glass", "granite"),
    )  # fmt: skip
    rate = drawn["rate"]
    # a multiplexed board: its fastest convert and 10 us, or spread over the sample
    skew = min(15e-6, 1 / (6 * rate)) if drawn["multiplexed"] else 0.0
    true_rate = rate * (1 + 50e-6 * off["clock"][0])
    ticks = np.arange(int(end * true_rate)) / true_rate
    volts = np.empty((6, len(ticks)))
    echoes = world.Echoes(room, motion)
    for i in range(3):
        size = drawn["amplitude"][i]
        offset = tuple(size * one for one in drawn["offset"][i])
        chain = world.Receiver(
            size, drawn["phase"][i], drawn["gain"][i], np.radians(drawn["quadrature_deg"][i]), offset
        )
        for part in range(2):
            volts[2 * i + part] = chain.volts(echoes.at(ticks + (2 * i + part) * skew, i))[part]
        volts[2 * i + 1] *= drawn["sign"]
        volts[2 * i : 2 * i + 2] += (
            size / math.sqrt(2) * 10 ** (-drawn["snr_db"] / 20) * rng.standard_normal((2, len(ticks)))
        )
    before = np.concatenate([np.roll(volts[-1], 1)[None], volts[:-1]])
    volts += drawn["crosstalk"] * (before - volts) * bool(skew)
    span = 5.0 if np.abs(volts).max() < 4.9 else 10.0
    scaling = span / 32768
    raw = np.clip(np.round(volts / scaling), -32768, 32767).astype(np.int16) if drawn["quantised"] else volts
    stated = {
        "radar": {"frequency_hz": frequency, "refractive_index": index, "phase_sign": drawn["sign"]},
        "transmitter": {
            "distance_m": drawn["tx_m"], "u_distance_m": u_m, "u_x_m": u_m, "u_y_m": u_m,
            "polarization_deg": drawn["polarization"], "u_polarization_deg": u_turn,
        },
        "receiver": [
            {
                "tilt_deg": drawn["tilt"][i], "azimuth_deg": drawn["azimuth"][i], "distance_m": drawn["rx_m"][i],
                "polarization_deg": angles[i], "u_tilt_deg": u_angle, "u_azimuth_deg": u_angle, "u_distance_m": u_m,
                "u_polarization_deg": u_turn,
            }
            for i in range(3)
        ],
        "tracer": {
            "diameter_m": drawn["diameter"], "u_diameter_m": drawn["u_diameter"], "density_kg_m3": 7800.0,
            "release_position_m": drawn["release"], "u_release_m": drawn["u_release"],
        },
        "floor": {"u_tilt_deg": 0.2}
        | ({"height_m": round(contact + 0.3e-3 * off["contact"][0], 5)} if drawn["floor_stated"] else {}),
        "site": {"g_m_s2": 9.81, "u_g_m_s2": 0.0005},
        "daq": {"rate_hz": rate, "channel_skew_s": skew, "u_clock_ppm": 50.0, "range_v": span},
    }  # fmt: skip
    off_u = {"transmitter.distance_m": off["distance"][3], "transmitter.polarization_deg": off["turn"][3]}
    off_u |= {"transmitter.x_m": off["beside"][0], "transmitter.y_m": off["beside"][1]}
    off_u |= {"tracer.diameter_m": off["diameter"][0]}
    off_u |= {f"tracer.release_position_m[{i + 1}]": off["release"][i] for i in range(3)}
    for i in range(3):
        names = (
            ("tilt", "tilt_deg"),
            ("azimuth", "azimuth_deg"),
            ("distance", "distance_m"),
            ("turn", "polarization_deg"),
        )
        off_u |= {f"receiver[{i + 1}].{key}": off[name][i] for name, key in names}
    scene = Scene(stated, room, motion, raw, scaling, {key: float(one) for key, one in off_u.items()}, drawn)
    scene.ticks, scene.skew = ticks, skew
    return scene


def written(value):
    """Return a value as TOML."""
    return str(value).lower() if isinstance(value, bool) else json.dumps(value)


def toml(stated):
    """Return the setup file."""
    lines = ["schema = 1"]
    for table, content in stated.items():
        for one in content if isinstance(content, list) else [content]:
            lines += ["", f"[[{table}]]" if isinstance(content, list) else f"[{table}]"]
            lines += [f"{key} = {written(value)}" for key, value in one.items()]
    return "\n".join(lines) + "\n"


class TooLongError(Exception):
    """The limit of a drop is over."""


def processed(scene, correction, name):
    """Return the program's result and the processor time."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "setup.toml"
        path.write_text(toml(scene.stated), encoding="utf-8")
        setup = radargui.read_setup(path)
    names = tuple(f"{letter}{i}" for i in (1, 2, 3) for letter in "IQ")
    scaling = tuple((0.0, scene.scaling) for _ in names) if scene.drawn["quantised"] else None
    recording = radargui.Recording(name, scene.raw, Digitisation(names, scene.drawn["rate"], scaling, scene.skew))
    began, until = time.process_time(), time.monotonic() + LIMIT_S

    def progress(_):
        if time.monotonic() > until:
            raise TooLongError

    result = radargui.process(radargui.Run(recording, setup), correction=correction, progress=progress)
    return result, time.process_time() - began


def score(scene, result, seconds):
    """Return one row of the table."""
    row = {"verdict": "refused", "status": result.status, "used": result.correction, "s": round(seconds, 1)}
    findings = result.details.findings
    row["findings"] = [f"{one.severity}:{one.code}" for one in findings]
    row["facts"] = [repr(one.facts) for one in findings if one.severity != "info"]
    row["words"] = list(result.warnings) or [result.reason or ""]
    if result.status != "ok":
        return row
    truth = scene.motion.at(scene.ticks).T
    place = result.position_m
    known = result.valid & np.isfinite(place).all(axis=0) & (scene.ticks >= scene.motion.pieces[1].begin)
    error = (place - truth)[:, known]
    shift = error.mean(axis=1)
    u = result.u_position_combined_m[:, known]
    row["known"] = round(float(known.sum() / (scene.ticks >= 0.7).sum()), 3)
    row["shape_mm"] = float(1e3 * np.sqrt(np.mean(np.sum((error - shift[:, None]) ** 2, axis=0))))
    row["place_mm"] = float(1e3 * np.linalg.norm(shift))
    row["u_place_mm"] = float(1e3 * np.sqrt(np.mean(np.sum(u**2, axis=0))))
    row["shift_mm"] = [round(1e3 * float(one), 3) for one in shift]
    row["u_held_mm"] = float(1e3 * np.sqrt(np.mean(np.sum(result.u_position_m[:, known] ** 2, axis=0))))
    row["e"] = []
    last = scene.ticks[-1]
    for number, (when, before, after) in enumerate(scene.motion.impacts):
        near = [one for one in result.bounces if abs(one.time_s * scene_clock(scene) - when) < 4e-3]
        if near and when < last - 0.05:
            one = near[0]
            stated = one.u_stated
            row["e"].append([number + 1, 100 * (one.e - after / before), 100 * stated, bool(one.valid)])
    first = next((one for one in row["e"] if one[0] == 1 and one[3] and np.isfinite(one[1])), None)
    row["missed"] = sum(after > 0.2 and when < last - 0.1 for when, _, after in scene.motion.impacts) - sum(
        scene.motion.impacts[one[0] - 1][2] > 0.2 and scene.motion.impacts[one[0] - 1][0] < last - 0.1
        for one in row["e"]
    )
    row["false"] = sum(
        all(abs(one.time_s * scene_clock(scene) - when) >= 4e-3 for when, _, _ in scene.motion.impacts)
        for one in result.bounces
    )
    row["first"] = first
    row["off_u"] = {key: round(one, 2) for key, one in scene.off_u.items()}
    return row


def judge(row):
    """Fill in the verdict: what is off by more than 4 u, and whether a warning names what is innocent."""
    if row["status"] != "ok":
        return row
    first, u_mm = row["first"], row["u_place_mm"]
    off = [first is not None and abs(first[1]) > 4 * first[2], row["place_mm"] > 4 * u_mm, row["shape_mm"] > 4 * u_mm]
    row["off"] = [name for name, is_off in zip(("e", "place", "shape"), off, strict=True) if is_off]
    told = [one for one in row["findings"] if not one.startswith("info")]
    row["named"] = {}
    for facts, code in zip(row["facts"], told, strict=True):
        if code.split(":")[1] in ("setup_contradicted", "polarization_off"):
            for place in NAMED.findall(facts):
                mine = {key: one for key, one in row["off_u"].items() if key.startswith(place)}
                if "polarization" in code:
                    mine = {key: one for key, one in mine.items() if "polarization" in key}
                row["named"] |= mine
    innocent = bool(row["named"]) and all(abs(one) < 2 for one in row["named"].values())
    row["verdict"] = "wrong cause" if innocent else ("right" if not row["off"] else "told" if told else "SILENT")
    return row


def scene_clock(scene):
    """Return true seconds a second of the program's time."""
    return scene.ticks[1] * scene.drawn["rate"]


def wilson(count, total):
    """Return the 95 % interval of a rate, in %."""
    if not total:
        return "-"
    z, p = 1.96, count / total
    middle, half = p + z * z / (2 * total), z * math.sqrt(p * (1 - p) / total + z * z / (4 * total**2))
    low, high = (100 * (middle + sign * half) / (1 + z * z / total) for sign in (-1, 1))
    return f"{count} of {total} = {100 * p:.0f} % ({low:.0f}-{high:.0f})"


def line(row):
    """Return a row for people."""
    head = f"{row['number']:4d} {'exact' if row['exact'] else 'off':5s} {row['floor']:15s} {row['verdict']:11s}"
    if "shape_mm" not in row:
        return f"{head} {row['s']:6.1f} s  {'; '.join(row['words'])[:150]}"
    first = row["first"]
    e = f"{first[1]:+8.4f} ({first[2]:.4f})" if first else f"{'no e':>17s}"
    inside = sum(abs(one[1]) <= 2 * one[2] for one in row["e"] if one[3])
    u_shape = f"({row['u_held_mm']:.3f})"
    within = "in" if row["place_mm"] <= 2 * row["u_place_mm"] else "OUT"
    place = f"{row['place_mm']:6.3f} ({row['u_place_mm']:.3f}) {within}"
    said = ",".join(one.split(":")[1] for one in row["findings"] if not one.startswith("info"))
    counts = f"{inside}/{sum(one[3] for one in row['e'])}"
    return f"{head} {e} {counts:>6s} {row['shape_mm']:7.4f} {u_shape} {place} {row['s']:5.1f} {row['used']} {said}"


def table(rows):
    """Print rows and rates."""
    heads = "first e % (u)      in 2u  shape mm (u)   place mm (u)     cpu s  findings"
    print(f"   # setup floor           verdict     {heads}")
    for row in rows:
        print(line(row))
    total = len(rows)
    for verdict in ("right", "told", "SILENT", "wrong cause", "refused"):
        print(f"{verdict:12s} {wilson(sum(row['verdict'] == verdict for row in rows), total)}")
    for label, chosen in (("exact", True), ("off", False)):
        some = [row for row in rows if "shape_mm" in row and row["exact"] == chosen]
        if not some:
            continue
        es = [one for row in some for one in row["e"] if one[3]]
        firsts = [row["first"] for row in some if row["first"]]
        print(f"{label}: all e inside 2u {wilson(sum(abs(one[1]) <= 2 * one[2] for one in es), len(es))}")
        print(f"  first e inside 2u {wilson(sum(abs(one[1]) <= 2 * one[2] for one in firsts), len(firsts))}")
        print(f"  place inside 2u {wilson(sum(row['place_mm'] <= 2 * row['u_place_mm'] for row in some), len(some))}")
        middle = [np.median([abs(one[at]) for one in firsts]) for at in (1, 2)] if firsts else [np.nan] * 2
        shape, place = (np.median([row[key] for row in some]) for key in ("shape_mm", "place_mm"))
        print(f"  medians: first e {middle[0]:.4f} % (u {middle[1]:.4f}), shape {shape:.4f} mm, place {place:.3f} mm")
    kept = [row for row in rows if "shape_mm" in row]
    print(f"impacts missed {sum(row['missed'] for row in kept)}, invented {sum(row['false'] for row in kept)}")


def main():
    """Run; 1 where a result is off and silent."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=20, help="scenes")
    parser.add_argument("--seed", type=int, help="left out: drawn")
    parser.add_argument("--first", type=int, default=0, metavar="K", help="number of the first scene")
    parser.add_argument("--only", type=int, nargs="+", metavar="K", help="these scenes")
    parser.add_argument("--correction", choices=["joint", "flights", "adaptive"], default="joint")
    parser.add_argument("--hold", nargs="+", default=[], metavar="NAME=JSON", help="held instead of drawn")
    parser.add_argument("--ideal", action="store_true", help="no errors, no floor, no noise")
    parser.add_argument("--rows", type=Path, help="file that rows are added to")
    parser.add_argument("--table", type=Path, help="print the rows of a file and end")
    parser.add_argument(
        "--within", type=float, default=math.inf, metavar="S", help="begin no scene after these seconds"
    )
    parser.add_argument("--words", action="store_true", help="print the warnings and what was named")
    asked = parser.parse_args()
    if asked.table:
        kept = [json.loads(text) for text in asked.table.read_text(encoding="utf-8").splitlines()]
        kept = [judge(row) for row in kept if row["correction"] == asked.correction]
        table(sorted(kept, key=lambda row: row["number"]))
        return int(any(row["verdict"] == "SILENT" for row in kept))
    seed = int(np.random.SeedSequence().entropy % 10**8) if asked.seed is None else asked.seed
    print(f"seed {seed}, {asked.correction}", flush=True)
    hold = {}
    for one in asked.hold:
        name, _, value = one.partition("=")
        try:
            hold[name] = json.loads(value)
        except json.JSONDecodeError:
            hold[name] = value
    began, rows = time.monotonic(), []
    for number in asked.only or range(asked.first, asked.first + asked.n):
        if time.monotonic() - began > asked.within:
            print(f"next is scene {number}")
            break
        scene = build(seed, number, hold, asked.ideal)
        begun = time.monotonic()
        try:
            row = score(scene, *processed(scene, asked.correction, f"drop-{number}"))
        except (radargui.RadarGuiError, TooLongError) as error:
            row = {
                "verdict": "refused",
                "status": "ended",
                "findings": [],
                "words": [repr(error)],
                "s": time.monotonic() - begun,
            }
        row |= {"number": number, "seed": seed, "correction": asked.correction, "floor": scene.drawn["floor"]}
        row = judge(row)
        row["exact"] = not any(abs(one) > 0 for one in scene.off_u.values())
        rows.append(row)
        print(line(row), flush=True)
        if asked.words:
            print(*(f"       {one}" for one in row["words"]), f"       {row.get('named')}", sep="\n", flush=True)
        if asked.rows:
            with asked.rows.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row, default=float) + "\n")
    table(rows)
    return int(any(row["verdict"] == "SILENT" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
