"""The read views in words: what the command line prints and the page shows, said once."""
