"""The paper's simulated mobile service robot: objects met on a tour of an indoor building, endless and seeded."""
