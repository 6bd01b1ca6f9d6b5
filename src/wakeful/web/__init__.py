"""The page: what the robots are thinking about and why, read from a journal beside whoever writes it."""

from wakeful.web.app import page
from wakeful.web.follow import Followed
from wakeful.web.serve import Unreachable, serve

__all__ = ["Followed", "Unreachable", "page", "serve"]
