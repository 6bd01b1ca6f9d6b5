"""The command line's entry: one group, its commands each in the file of its concern."""

from __future__ import annotations

import os

import click

from wakeful.cli.audit import audit_command
from wakeful.cli.compact import backup_command, compact_command
from wakeful.cli.debt import debt_command
from wakeful.cli.experience import experience_group
from wakeful.cli.export import export_command
from wakeful.cli.guarantee import guarantee_command
from wakeful.cli.learned import learning_command, trust_command
from wakeful.cli.look import events_command, processes_command, status_command
from wakeful.cli.mistakes import OneLine
from wakeful.cli.new import new_group
from wakeful.cli.operate import cancel_command, reopen_command, resume_command, suspend_command
from wakeful.cli.reproduce import reproduce_command
from wakeful.cli.revisit import revisit_command
from wakeful.cli.rollback import rollback_command
from wakeful.cli.run import run_command
from wakeful.cli.simulate import simulate_command
from wakeful.cli.stats import stats_command
from wakeful.cli.trace import timeline_command, trace_command
from wakeful.cli.vocabulary import domains_command, treatments_command
from wakeful.cli.watch import watch_command
from wakeful.cli.web import web_command
from wakeful.cli.why import why_command
from wakeful.version import __version__


@click.group(cls=OneLine, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="wakeful")
@click.pass_context
def main(context: click.Context) -> None:
    """Continuous cognitive coverage for robots: every event admitted into cognition gets a treatment that fits it.

    Begin with 'wakeful run service_robot', or with a recording of your own. Each option can also be set in the environment
    (WAKEFUL_JOURNAL, WAKEFUL_SPEED, …); NO_COLOR switches colours off.
    """
    if os.environ.get("NO_COLOR"):
        context.color = False


for command in (
    run_command,
    status_command,
    events_command,
    processes_command,
    suspend_command,
    resume_command,
    cancel_command,
    reopen_command,
    debt_command,
    why_command,
    trace_command,
    timeline_command,
    audit_command,
    stats_command,
    trust_command,
    learning_command,
    guarantee_command,
    rollback_command,
    revisit_command,
    domains_command,
    treatments_command,
    export_command,
    compact_command,
    backup_command,
    experience_group,
    new_group,
    simulate_command,
    reproduce_command,
    watch_command,
    web_command,
):
    main.add_command(command)
