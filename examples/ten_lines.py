"""A mind inside a synchronous program."""

import wakeful

with wakeful.Mind("service_robot") as mind:
    receipt = mind.admit("object", "box 7", {"category": "obstacle", "state": "unstable", "location": "edge"}, criticality=2)
    decided, result = mind.decision(receipt.event), mind.result(receipt.event)
    print(decided.decision.reasons[0] if decided else "still thinking")
    print(result.says if result else "still thinking")
    mind.outcome(receipt.event, "intervention")
