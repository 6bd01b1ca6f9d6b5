"""A mind that runs by itself beside the rest of an asyncio program."""

import asyncio
import time

import wakeful


async def main() -> None:
    """Admit an event, do something else, and hear what was concluded."""
    async with wakeful.open_live("service_robot") as mind:
        fields: dict[str, wakeful.Field] = {"category": "device", "state": "abnormal", "location": "center"}
        draft = wakeful.Draft(kind="object", entity="pump 3", source="", position=0, at_ns=time.time_ns(), fields=fields)
        receipt = await mind.admit(draft)  # durable from here on
        print(receipt.status)
        print(mind.kernel.result(await mind.concluded(receipt.event)).says)


asyncio.run(main())
