"""Runs: folders that hold a result, written whole and taken up again."""
