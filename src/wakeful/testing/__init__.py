"""Contract suites that anybody's treatment, policy, reasoner, learner, journal or bridge can be checked with."""

from wakeful.testing.broken import ContractBroken
from wakeful.testing.scripted_mind import Script, ScriptedMind
from wakeful.testing.treatment_checks import check_treatment

__all__ = ["ContractBroken", "Script", "ScriptedMind", "check_treatment"]
