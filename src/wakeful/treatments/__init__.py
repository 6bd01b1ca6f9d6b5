"""Ways of thinking, one file each, behind contracts/treatment.py; each returns a typed result of its own."""
