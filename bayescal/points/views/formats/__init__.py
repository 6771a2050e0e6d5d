"""Files that hold views of a target, one module each.

Each module has a NAME for messages, ``recognises(source)`` and ``read(source)``. The first that
recognises a file reads it; a table of text is what remains.
"""
