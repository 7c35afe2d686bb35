"""The command ``airlight``."""
