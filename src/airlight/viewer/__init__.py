"""The viewer: one session a view, the same for the page, for notebooks and for a window of its own.

A client sends messages of plain data, and gets the state, pictures and answers back; see ``session``. State on the wire is
the very plain data that a scene file holds (``wire``), which clients change by edits (``edits``). What has changed is drawn
by the one renderer that all sessions share (``stream``).
"""
