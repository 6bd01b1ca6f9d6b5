"""Contract suites that anybody's treatment, policy, reasoner, learner, journal or bridge can be checked with."""

from wakeful.testing.bridge_checks import check_bridge
from wakeful.testing.broken import ContractBroken
from wakeful.testing.journal_checks import check_journal
from wakeful.testing.learner_checks import check_learner
from wakeful.testing.policy_checks import check_policy
from wakeful.testing.reasoner_checks import check_reasoner
from wakeful.testing.scripted_mind import Exchange, Request, Script, ScriptedMind
from wakeful.testing.treatment_checks import check_treatment

__all__ = [
    "ContractBroken",
    "Exchange",
    "Request",
    "Script",
    "ScriptedMind",
    "check_bridge",
    "check_journal",
    "check_learner",
    "check_policy",
    "check_reasoner",
    "check_treatment",
]
