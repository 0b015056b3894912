"""The library of instruments: one TOML file each, with wording, anchors, scoring and source."""
