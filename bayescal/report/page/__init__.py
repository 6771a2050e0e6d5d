"""The report: one self-contained page. Values first (blocks, sections), then a template."""
