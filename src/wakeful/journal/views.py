"""The read views: one door for the command line and the page. Each works on any journal through its lines."""

from wakeful.journal.history import EventPast, History, ProcessPast, history, waits_for
from wakeful.journal.incidents import Heard, KindStats, Stats, stats, stats_of
from wakeful.journal.readable import Readable, View, event_of, process_of, tag_of
from wakeful.journal.story import NoSuchEvent, Story, find_event, story
from wakeful.journal.strange import StrangeEpisode, strangest
from wakeful.journal.summary import Accuracy, Share, Stretch, Summary, covered, share, summary, summary_of

__all__ = [
    "Accuracy",
    "EventPast",
    "Heard",
    "History",
    "KindStats",
    "NoSuchEvent",
    "ProcessPast",
    "Readable",
    "Share",
    "Stats",
    "Story",
    "StrangeEpisode",
    "Stretch",
    "Summary",
    "View",
    "covered",
    "event_of",
    "find_event",
    "history",
    "process_of",
    "share",
    "stats",
    "stats_of",
    "story",
    "strangest",
    "summary",
    "summary_of",
    "tag_of",
    "waits_for",
]
