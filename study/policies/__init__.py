"""Policy files that come with the software."""
