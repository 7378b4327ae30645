#!/usr/bin/env python3
"""The udev rules against adapters that are described here, by a small reading of udev's own language (udev(7)): every
key, operator, GOTO and LABEL is known, an attribute is written only where the kernel has one, and a disk is left alone.
Nobody's udev runs in here: a rule that this reading accepts was not proved by a kernel's event.

  udev_rules_test.py RULES UNIT_FOLDER"""

import fnmatch
import os
import re
import sys

PAIR = re.compile(r'\s*([A-Z_]+)(?:\{([^}]*)\})?\s*(==|!=|\+=|-=|:=|=)\s*"([^"]*)"\s*(,|$)')
# key -> operators that udev takes for it; with {} where it needs a name
MATCH = {"ACTION": False, "SUBSYSTEM": False, "SUBSYSTEMS": False, "KERNEL": False, "DRIVERS": False, "ATTRS": True}
PARENT = {"SUBSYSTEMS", "DRIVERS", "ATTRS"}
ASSIGN = {"ENV": (True, ("=", "+=")), "SYMLINK": (False, ("+=",)), "TAG": (False, ("+=",)), "GROUP": (False, ("=",)),
          "MODE": (False, ("=",)), "GOTO": (False, ("=",)), "LABEL": (False, ("=",)), "ATTR": (True, ("=",))}


def parse(text):
    """[(line number, [(key, name, operator, value)])]; ValueError with the line."""
    rules, labels = [], set()
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        at, rule = 0, []
        while at < len(line):
            pair = PAIR.match(line, at)
            if not pair:
                raise ValueError(f"line {number}: not a pair at '{line[at:at + 30]}'")
            key, name, operator, value, more = pair.groups()
            needs, operators = (MATCH[key], ("==", "!=")) if key in MATCH else ASSIGN.get(key, (None, ()))
            if operator not in operators or needs != (name is not None):
                raise ValueError(f"line {number}: udev does not take {key} {operator}")
            if not more and pair.end() < len(line) or more and not line[pair.end():].strip():
                raise ValueError(f"line {number}: a comma is missing or too many")
            if key == "LABEL":
                labels.add(value)
            rule.append((key, name, operator, value))
            at = pair.end()
        rules.append((number, rule))
    for number, rule in rules:
        for key, _, _, value in rule:
            if key == "GOTO" and value not in labels:
                raise ValueError(f"line {number}: GOTO {value} leads nowhere")
    return rules


def holds(operator, pattern, value):
    hit = value is not None and any(fnmatch.fnmatchcase(value, one) for one in pattern.split("|"))
    return hit == (operator == "==")


def matches(rule, device):
    own = {"ACTION": device["action"], "SUBSYSTEM": device["chain"][0]["subsystem"], "KERNEL": device["name"]}
    for key, _, operator, value in rule:
        if key in own and not holds(operator, value, own[key]):
            return False
    wanted = [pair for pair in rule if pair[0] in PARENT]
    # All of a rule's parent keys must hold for one device of the chain, itself included.
    return not wanted or any(
        all(holds(operator, value, {"SUBSYSTEMS": d["subsystem"], "DRIVERS": d.get("driver"),
                                    "ATTRS": d.get("attrs", {}).get(name)}[key])
            for key, name, operator, value in wanted) for d in device["chain"])


def run(rules, device):
    """What udev would do to the device; ValueError where it would only log an error."""
    done = {"env": {}, "links": [], "tags": [], "attr": {}}
    skip = None
    for number, rule in rules:
        if skip is not None:
            if ("LABEL", None, "=", skip) not in rule:
                continue
            skip = None
        if not matches(rule, device):
            continue
        for key, name, operator, value in rule:
            if key == "GOTO":
                skip = value
            elif key == "ENV":
                old = done["env"].get(name)
                done["env"][name] = f"{old} {value}" if operator == "+=" and old else value
            elif key == "SYMLINK":
                done["links"].append(value)
            elif key == "TAG":
                done["tags"].append(value)
            elif key == "ATTR":
                if name not in device["writable"]:
                    raise ValueError(f"line {number}: {device['name']} has no attribute {name}")
                done["attr"][name] = value
            elif key in ("GROUP", "MODE"):
                done[key.lower()] = value
    return done


def adapter(vendor, serial, driver, action="add", subsystem="tty"):
    """What sysfs shows of ttyUSB0, from the terminal up to the adapter; the port's attributes lie under device/."""
    return {"action": action, "name": "ttyUSB0",
            "writable": {"device/latency_timer"} if driver == "ftdi_sio" else set(),
            "chain": [{"subsystem": subsystem}, {"subsystem": "usb-serial", "driver": driver},
                      {"subsystem": "usb", "driver": driver, "attrs": {"bInterfaceNumber": "00"}},
                      {"subsystem": "usb", "driver": "usb", "attrs": {"idVendor": vendor, "serial": serial}}]}


def check(what, got, wanted):
    if got != wanted:
        raise SystemExit(f"FAILED: {what}: {got!r}, expected {wanted!r}")


def refused(what, text, device=None):
    try:
        rules = parse(text)
        if device:
            run(rules, device)
    except ValueError:
        return
    raise SystemExit(f"FAILED: {what} is not noticed: the test is blind")


def main():
    path, units = sys.argv[1:]
    with open(path, encoding="ascii") as file:
        text = file.read()
    rules = parse(text)
    for vendor, driver in (("0403", "ftdi_sio"), ("1a86", "ch341"), ("10c4", "cp210x"), ("0483", "cdc_acm"),
                           ("2341", "cdc_acm")):
        done = run(rules, adapter(vendor, "X1", driver))
        check(f"{vendor}: modem probing", done["env"].get("ID_MM_DEVICE_IGNORE"), "1")
        check(f"{vendor}: braille", done["env"].get("BRLTTY_BRAILLE_DRIVER"), "")
        check(f"{vendor}: group and mode", (done["group"], done["mode"]), ("dialout", "0660"))
        check(f"{vendor}: latency", done["attr"], {"device/latency_timer": "1"} if driver == "ftdi_sio" else {})
        check(f"{vendor}: links before anyone edits", done["links"], [])
    nothing = {"env": {}, "links": [], "tags": [], "attr": {}}
    check("an adapter that goes", run(rules, adapter("0403", "X1", "ftdi_sio", action="remove")), nothing)
    check("another vendor's", run(rules, adapter("1234", "X1", "other")), nothing)
    check("a disk", run(rules, adapter("0403", "X1", "ftdi_sio", subsystem="block")), nothing)

    # The line that the reader is told to copy, as a shop would fill it in.
    example = re.findall(r"^# (SUBSYSTEMS==.*)$", text, re.MULTILINE)
    check("example lines", len(example), 1)
    line = example[0].replace("A50285BI", "SHOP7").replace("NAME", "ac5")
    named = parse(text.replace("# " + example[0], line))
    done = run(named, adapter("0403", "SHOP7", "ftdi_sio"))
    check("stable name", done["links"], ["machine/ac5"])
    check("tag", done["tags"], ["systemd"])
    check("service", done["env"].get("SYSTEMD_WANTS"), "tiltfeed@ac5.service")
    check("the service's unit", os.path.exists(os.path.join(units, "tiltfeed@.service")), True)
    check("another adapter's name", run(named, adapter("0403", "OTHER", "ftdi_sio"))["links"], [])

    refused("a key that udev does not have", text.replace("SUBSYSTEMS==", "SUBSISTEMS=="))
    refused("a missing quote", text.replace('MODE="0660"', "MODE=0660"))
    refused("a label that is gone", text.replace('LABEL="tiltfeed_end"', ""))
    refused("a match that became an assignment", text.replace('SUBSYSTEM!="tty"', 'SUBSYSTEM="tty"'))
    refused("a missing comma", text.replace('"ftdi_sio", ATTR', '"ftdi_sio" ATTR'))
    refused("an attribute of the wrong device", text.replace("device/latency_timer", "latency_timer"),
            adapter("0403", "X1", "ftdi_sio"))
    print("udev rules: as expected")


main()
