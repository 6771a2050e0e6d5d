"""Files that other programs write, one module each.

A module has ``recognises(content)``, which looks at the bytes alone, and ``read(content, view)``,
which makes a table of them. The first of `bayescal.points.reader.EXPORTS` that recognises a
file reads it; what remains is read as a table of text.
"""
