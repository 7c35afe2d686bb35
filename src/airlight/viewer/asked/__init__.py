"""What clients may ask of a session, a module each; see ``viewer.asking``."""
