"""Who may speak to the server and how much, how messages travel, and how the server runs."""
