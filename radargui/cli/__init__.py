"""The command line: one door to everything; a headless command loads no Qt."""

from radargui.cli.app import main

__all__ = ["main"]
