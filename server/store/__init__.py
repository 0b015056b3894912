"""The only place that knows SQL: functions that take a session and never commit."""
