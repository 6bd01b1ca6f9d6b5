"""What a Noted says of a process that did not go on as it was: status names each such process, so that none is left silent."""

from __future__ import annotations

#: The code asks for something else than was recorded: the process began again from its event.
MISMATCH = "code no longer matches its record"

#: The process's treatment is not registered any more: it goes on in fallback mode, with a general treatment.
REMOVED = "treatment removed"

#: The learned model was fitted to other fields or labels than the domain now has: guidelines decide until the next version.
MODEL_LEFT = "model not usable"
