"""`wakeful simulate`: a seeded stream of a simulated robot's messages, to try things on."""

from __future__ import annotations

import itertools
import sys

import click
import msgspec

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import option
from wakeful.domains import load, names


@click.command("simulate")
@click.argument("domain")
@option("--messages", type=click.IntRange(min=1), default=1000, show_default=True, help="How many messages.")
@option("--seed", type=int, default=0, show_default=True, help="The same seed, the same stream.")
def simulate_command(domain: str, messages: int, seed: int) -> None:
    """Write a simulated robot's messages as JSON lines to standard output."""
    stream = load(domain).simulate(seed)
    if stream is None:
        simulators = [name for name in names() if load(name).simulate(0) is not None]
        raise Mistake(f"the domain {domain} has no simulator; those that have one are {', '.join(simulators)}")
    encoder = msgspec.json.Encoder()
    for observation in itertools.islice(stream, messages):
        sys.stdout.buffer.write(encoder.encode(observation.values))
        sys.stdout.buffer.write(b"\n")
    sys.stdout.buffer.flush()
