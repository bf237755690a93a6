"""Speed, measured side by side with what else a user would pick."""
