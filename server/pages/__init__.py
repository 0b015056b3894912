"""The pages: what participants and staff read and send."""
