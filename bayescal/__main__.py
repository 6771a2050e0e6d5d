"""``python -m bayescal``."""

from bayescal.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
