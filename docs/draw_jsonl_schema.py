"""Writes docs/jsonl.schema.json, the JSON schema of a line, from the types that the ``jsonl`` bridge decodes into.

Run it after they have changed; tests/bridges/test_json_lines.py fails until the committed schema agrees.
"""

from __future__ import annotations

import json
from pathlib import Path

import msgspec

from wakeful.bridges.json_lines import LINES

TARGET = Path(__file__).parent / "jsonl.schema.json"


def schema() -> str:
    """The schema as JSON text."""
    lines, parts = msgspec.json.schema_components(LINES.values(), schema_hook=_anything, ref_template="#/$defs/{name}")
    whole = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A line of wakeful's jsonl bridge",
        "description": "Any other JSON object is an observation too: see docs/jsonl.md.",
        "oneOf": list(lines),
        "$defs": parts,
    }
    return json.dumps(whole, indent=2, sort_keys=False) + "\n"


def _anything(kind: type) -> dict[str, object]:
    """A value of which nothing is known beforehand may be any JSON."""
    if kind is object:
        return {"description": "any JSON"}
    raise NotImplementedError(f"no schema for {kind}")


if __name__ == "__main__":
    TARGET.write_text(schema())
