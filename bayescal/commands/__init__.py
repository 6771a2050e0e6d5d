"""The commands, one module each: its options and what it does.

Modules here import nothing heavy at the top, so that ``--help`` stays quick.
"""
