"""A treatment of one's own: one coroutine that awaits only the mind."""

import wakeful


class Inspection(wakeful.Result, frozen=True, kw_only=True, tag="inspection"):
    """What an inspection found."""

    readings: tuple[float, ...]


@wakeful.treatment(says="Looks at a device twice, some time apart, before it says anything.")
async def inspection(event: wakeful.Event, mind: wakeful.MindView) -> Inspection:
    """Spend a step, wait for a reading that may come much later, and say what it showed."""
    await mind.work()
    later = await mind.evidence("reading", event.entity, within_s=30)
    readings = tuple(float(each.at_ns) for each in later)
    return Inspection(
        says=f"{event.entity}: {len(readings)} readings",
        confidence=0.5 + 0.4 * bool(readings),
        rests_on=tuple(each.id for each in later) or (event.id,),
        would_change=("a reading out of its range",),
        forecast=mind.forecast(),
        readings=readings,
    )


registry = wakeful.Registry(own=(inspection,))
with wakeful.Mind("jsonl", registry=registry) as mind:
    receipt = mind.admit("alarm", "pump 3", {"text": "pressure low"})
    print(receipt.status, "inspection" in registry.names())
