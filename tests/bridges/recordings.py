"""Small recordings of every kind, written by the tests themselves."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Bag1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag2Writer
from rosbags.typesys import Stores, get_typestore

START_NS = 1_700_000_000_000_000_000
STEP_NS = 100_000_000
ODOMETRY = "nav_msgs/msg/Odometry"
STRING = "std_msgs/msg/String"


def at_ns(number: int) -> int:
    """When message ``number`` was recorded."""
    return START_NS + number * STEP_NS


def odometry(store: Any, number: int) -> Any:
    """A base that drives along x and has turned by 90°; its stamp is 20 ms before its receipt."""
    types = store.types
    header: dict[str, Any] = {"frame_id": "odom"}
    stamp_ns = at_ns(number) - 20_000_000
    header["stamp"] = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__:
        header["seq"] = number
    vector = types["geometry_msgs/msg/Vector3"]
    pose = types["geometry_msgs/msg/Pose"](
        types["geometry_msgs/msg/Point"](0.1 * number, 0.0, 0.0),
        types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.5**0.5, 0.5**0.5),
    )
    twist = types["geometry_msgs/msg/Twist"](vector(1.0, 0.0, 0.0), vector(0.0, 0.0, float("nan")))
    return types[ODOMETRY](
        types["std_msgs/msg/Header"](**header),
        "base_link",
        types["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36)),
        types["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36)),
    )


def ros1_bag(path: Path, count: int = 20, packing: Bag1Writer.CompressionFormat | None = None) -> Path:
    """Odometry, and a text every fifth message."""
    store = get_typestore(Stores.ROS1_NOETIC)
    writer = Bag1Writer(path)
    if packing:
        writer.set_compression(packing)
    with writer:
        base = writer.add_connection("/odom", ODOMETRY, typestore=store)
        chat = writer.add_connection("/chatter", STRING, typestore=store)
        for number in range(count):
            writer.write(base, at_ns(number), store.serialize_ros1(odometry(store, number), ODOMETRY))
            if number % 5 == 0:
                said = store.types[STRING](f"number {number}")
                writer.write(chat, at_ns(number), store.serialize_ros1(said, STRING))
    return path


def ros2_bag(path: Path, count: int = 20, storage: StoragePlugin = StoragePlugin.SQLITE3) -> Path:
    """The directory of a ROS 2 bag with odometry."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Bag2Writer(path, version=9, storage_plugin=storage) as writer:
        base = writer.add_connection("/odom", ODOMETRY, typestore=store)
        for number in range(count):
            writer.write(base, at_ns(number), store.serialize_cdr(odometry(store, number), ODOMETRY))
    return path


def mcap(path: Path, count: int = 20, packing: CompressionType = CompressionType.ZSTD, chunk_bytes: int = 2_000) -> Path:
    """ROS 2 odometry with its definition, JSON messages, and one of an encoding that nobody reads."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    definition, _ = store.generate_msgdef(ODOMETRY, ros_version=2)
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=chunk_bytes, compression=packing)
        writer.start()
        base = writer.register_channel("/odom", "cdr", writer.register_schema(ODOMETRY, "ros2msg", definition.encode()))
        battery = writer.register_channel("/battery", "json", writer.register_schema("battery", "jsonschema", b"{}"))
        other = writer.register_channel("/other", "protobuf", writer.register_schema("other", "protobuf", b""))
        for number in range(count):
            writer.add_message(base, at_ns(number), bytes(store.serialize_cdr(odometry(store, number), ODOMETRY)), at_ns(number))
            if number % 5 == 0:
                writer.add_message(battery, at_ns(number), json.dumps({"charge": 1 - number / 100}).encode(), at_ns(number))
        writer.add_message(other, at_ns(count), b"\x08\x01", at_ns(count))
        writer.finish()
    return path


class Ulog:
    """A flight log, message by message, as its format has it (https://docs.px4.io/main/en/dev_log/ulog_file_format.html)."""

    def __init__(self) -> None:
        self.content = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000))
        self._ids: dict[tuple[str, int], int] = {}

    def add(self, kind: bytes, body: bytes) -> None:
        """One message of any kind."""
        self.content += struct.pack("<HB", len(body), kind[0]) + body

    def format(self, name: str, fields: str) -> None:
        """A topic's fields, ``uint64_t timestamp;float voltage``."""
        self.add(b"F", f"{name}:{fields};".encode())

    def subscribe(self, name: str, instance: int = 0) -> None:
        """Rows of this topic will follow."""
        number = self._ids[name, instance] = len(self._ids)
        self.add(b"A", struct.pack("<BH", instance, number) + name.encode())

    def row(self, name: str, packed: bytes, instance: int = 0) -> None:
        """One row, packed as the format says."""
        self.add(b"D", struct.pack("<H", self._ids[name, instance]) + packed)

    def say(self, at_us: int, level: int, words: str) -> None:
        """A log message."""
        self.add(b"L", struct.pack("<BQ", ord("0") + level, at_us) + words.encode())


def ulog(path: Path, rows: int = 300) -> Path:
    """A quick stream at 100 Hz with a flag that changes once, a status at 1 Hz, two batteries, messages, a dropout."""
    log = Ulog()
    log.add(b"B", bytes(40))
    log.format("sensor_combined", "uint64_t timestamp;float[3] gyro;bool clipping;uint8_t[4] _padding0")
    log.format("vehicle_status", "uint64_t timestamp;uint8_t nav_state;char[8] mode")
    log.format("battery_status", "uint64_t timestamp;float voltage")
    for name, instance in (("sensor_combined", 0), ("vehicle_status", 0), ("battery_status", 0), ("battery_status", 1)):
        log.subscribe(name, instance)
    log.say(1_000_000, 6, "[commander] \x1b[32mReady for takeoff!\x1b[0m\t")
    for number in range(rows):
        at_us = 1_000_000 + number * 10_000
        gyro = (0.1, float("nan"), float(number))
        log.row("sensor_combined", struct.pack("<Q3f?", at_us, *gyro, number >= rows // 2 + 3))
        if number % 100 == 0:
            log.row("vehicle_status", struct.pack("<QB8s", at_us, number // 100, b"MISSION\0"))
            log.row("battery_status", struct.pack("<Qf", at_us, 12.5))
            log.row("battery_status", struct.pack("<Qf", at_us, 11.5), 1)
    log.add(b"O", struct.pack("<H", 26))
    log.say(1_000_000 + rows * 10_000, 2, "Failsafe activated")
    path.write_bytes(log.content)
    return path


def csv(path: Path, rows: int = 20) -> Path:
    """A second a row, with a blank cell and a NaN."""
    lines = ["timestamp,speed,stopped,note ", *(f"2026-03-01T10:00:{row:02}Z,{row / 10},{row == 5},ok" for row in range(rows))]
    lines[3] = "2026-03-01T10:00:02Z,,False,"
    lines[4] = "2026-03-01T10:00:03Z,NaN,False,ok"
    path.write_text("\n".join(lines) + "\n")
    return path


def xlsx(path: Path, rows: Sequence[Sequence[object]]) -> Path:
    """A workbook with one sheet, as small as the format allows."""
    main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    links = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    package = "http://schemas.openxmlformats.org/package/2006"
    office = "application/vnd.openxmlformats-officedocument.spreadsheetml"
    files = {
        "[Content_Types].xml": f'<Types xmlns="{package}/content-types"><Default Extension="rels" '
        'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        f'<Override PartName="/xl/workbook.xml" ContentType="{office}.sheet.main+xml"/>'
        f'<Override PartName="/xl/worksheets/sheet1.xml" ContentType="{office}.worksheet+xml"/></Types>',
        "_rels/.rels": f'<Relationships xmlns="{package}/relationships"><Relationship Id="r1" Type="{links}/officeDocument" '
        'Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook xmlns="{main}" xmlns:r="{links}"><sheets><sheet name="data" sheetId="1" r:id="r1"/>'
        "</sheets></workbook>",
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{package}/relationships"><Relationship Id="r1" '
        f'Type="{links}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>',
        "xl/worksheets/sheet1.xml": f'<worksheet xmlns="{main}"><sheetData>{"".join(map(_row, rows))}</sheetData></worksheet>',
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, f'<?xml version="1.0" encoding="UTF-8"?>{text}')
    return path


def _row(cells: Iterable[object]) -> str:
    return f"<row>{''.join(map(_cell, cells))}</row>"


def _cell(value: object) -> str:
    if value is None:
        return "<c/>"
    if isinstance(value, bool):
        return f'<c t="b"><v>{int(value)}</v></c>'
    if isinstance(value, int | float):
        return f"<c><v>{value}</v></c>"
    text = str(value).replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return f'<c t="inlineStr"><is><t xml:space="preserve">{text}</t></is></c>'


def sheet(path: Path, rows: int = 20) -> Path:
    """A workbook as robots' exporters write them: a header with a trailing blank, times in two manners, blank cells."""
    table: list[list[object]] = [["Num", "Timestamp", "Current_J0", "stopped", "cycle "]]
    for row in range(rows):
        stamp = f"2026-03-01T10:00:{row:02}.500Z"
        table.append([row + 1, f'"{stamp}"' if row % 3 == 0 else stamp, None if row == 4 else row / 10, row == 7, 1])
    return xlsx(path, table)


def json_lines(path: Path, rows: int = 20) -> Path:
    """Every kind of line."""
    lines: list[object] = []
    for row in range(rows):
        at = f"2026-03-01T10:00:{row:02}Z"
        lines.append(
            (
                {"observation": {"at": at, "topic": "base", "values": {"speed": row / 10}}},
                {"event": {"at": at, "kind": "blocked", "entity": "aisle", "fields": {"load": 0.5}, "criticality": 2}},
                {"evidence": {"at": at, "topic": "clearance", "key": "aisle", "value": [1, 2]}},
                {"outcome": {"at": at, "label": "intervention", "entity": "aisle"}},
                {"timestamp": at, "topic": "pump", "pressure": row},
                {
                    "time": 1_772_359_200 + row,
                    "version": "2.0.0",
                    "manufacturer": "m",
                    "serialNumber": "s",
                    "operatingMode": "MANUAL",
                },
            )[row % 6]
        )
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return path


def made(folder: Path) -> dict[str, Path]:
    """One file of each kind, by suffix."""
    bag2 = ros2_bag(folder / "bag2")
    return {
        ".csv": csv(folder / "a.csv"),
        ".xlsx": sheet(folder / "a.xlsx"),
        ".ulg": ulog(folder / "a.ulg", 120),
        ".bag": ros1_bag(folder / "a.bag"),
        ".db3": next(bag2.glob("*.db3")),
        ".mcap": mcap(folder / "a.mcap"),
        ".jsonl": json_lines(folder / "a.jsonl"),
    }


def in_memory(content: bytes) -> io.BytesIO:
    """Bytes as standard input would give them."""
    return io.BytesIO(content)
