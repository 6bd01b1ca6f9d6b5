"""The experiments' worlds: seeded, with every parameter declared."""
