"""The domain of JSON lines that no better one is known for: any robot, any kind of event, any field."""
