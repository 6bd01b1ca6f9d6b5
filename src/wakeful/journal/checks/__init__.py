"""What an audit checks, one concern a file."""
