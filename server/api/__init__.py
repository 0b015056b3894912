"""The interface for programs: staff's JSON under `/api/v1`."""
