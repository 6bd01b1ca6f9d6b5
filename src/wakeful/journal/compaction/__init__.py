"""Compaction: rows of closed events that are older than the retention become counts, a few rows at a time."""
