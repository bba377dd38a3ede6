"""Time of cheap calls while others send bad bodies: ``python -m bench.hostile``.

The service, started as a user starts it, is asked for its list of shapes at a steady rate: first
alone, then while clients post bodies of 1 MB, one after the other, that are full of bad items.
Percentiles of both runs stand side by side.
"""

import asyncio
import json
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import httpx2
import numpy as np

from bench.command_line import command_line, parsed, print_json
from demo.stack import running_stack

_BYTES = 1024**2 - 1000
_INTERVAL = 0.05
"""Seconds between cheap calls."""

_LEAD = 2.0
"""Seconds that bad bodies are sent before the first call is measured."""


def bad_bodies() -> list[tuple[str, bytes]]:
    """Paths, and bodies of about 1 MB that are not valid there."""
    pair = {"source": "a", "target": "b"}
    return [
        ("/v1/matches", _filled({**pair, "landmarks": []}, "landmarks", [])),
        ("/v1/matches", _filled({**pair, "landmarks": []}, "landmarks", [1, "x" * 40])),
        ("/v1/matches", _filled({**pair, "metric": []}, "metric", "x" * 20)),
        ("/v1/matches", json.dumps(pair | {f"k{n:014}": 0 for n in range(45_000)}).encode()),
        ("/v1/dissimilarities", _filled({"shapes": []}, "shapes", "x" * 20)),
        ("/v1/prototypes", _filled({"shapes": ["a"]}, "correspondences", list(range(200)))),
    ]


def _filled(body: dict[str, Any], field: str, item: Any) -> bytes:
    """A body whose list has as many items as fit."""
    count = _BYTES // (len(json.dumps(item)) + 2)
    return json.dumps({**body, field: [item] * count}).encode()


async def calls(url: str, seconds: float) -> list[float]:
    """Seconds of each cheap call."""
    times: list[float] = []

    async def call(client: httpx2.AsyncClient) -> None:
        started = time.perf_counter()
        (await client.get("/v1/shapes")).raise_for_status()
        times.append(time.perf_counter() - started)

    async with httpx2.AsyncClient(base_url=url) as client:
        pending = []
        for _ in range(round(seconds / _INTERVAL)):
            pending.append(asyncio.create_task(call(client)))
            await asyncio.sleep(_INTERVAL)
        await asyncio.gather(*pending)
    return times


async def attack(url: str, attackers: int, seconds: float) -> dict[int, int]:
    """Send bad bodies, and count how many were answered with each status."""
    bodies, answered = bad_bodies(), Counter[int]()
    end = time.monotonic() + seconds

    async def send(number: int) -> None:
        async with httpx2.AsyncClient(base_url=url, timeout=300.0) as client:
            while time.monotonic() < end:
                path, body = bodies[number % len(bodies)]
                headers = {"content-type": "application/json"}
                answer = await client.post(path, content=body, headers=headers)
                answered[answer.status_code] += 1
                number += 1

    await asyncio.gather(*(send(number) for number in range(attackers)))
    return dict(answered)


def main() -> None:
    """Measure alone and under attack, print percentiles."""
    parser = command_line(__doc__)
    parser.add_argument("--attackers", type=int, default=50, help="clients that send bad bodies")
    parser.add_argument("--seconds", type=float, default=15.0, help="of each run")
    arguments = parsed(parser)
    rows = []
    with running_stack({"ISOMATCH_LOG_LEVEL": "WARNING"}) as stack:
        print(f"{'clients':>8}{'calls':>8}{'median':>10}{'99 %':>10}{'longest':>10}  bad bodies")
        for attackers in (0, arguments.attackers):
            with ProcessPoolExecutor(1) as other:
                # In a process of its own, so that sending does not delay the calls.
                sent = other.submit(
                    _attack_in_process, stack.url, attackers, arguments.seconds + _LEAD
                )
                time.sleep(_LEAD)
                times = np.array(asyncio.run(calls(stack.url, arguments.seconds)))
                figures = [float(np.quantile(times, one)) for one in (0.5, 0.99, 1.0)]
                row = "".join(f"{1000 * one:7.0f} ms" for one in figures)
                answered = sent.result()
                print(f"{attackers:8}{len(times):8}{row}  {answered}")
                seconds = dict(zip(("median", "percentile_99", "longest"), figures, strict=True))
                rows.append({"attackers": attackers, "calls": len(times), **seconds})
    print_json(arguments, rows)


def _attack_in_process(url: str, attackers: int, seconds: float) -> dict[int, int]:
    return asyncio.run(attack(url, attackers, seconds))


if __name__ == "__main__":
    main()
