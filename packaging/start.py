"""Where the frozen program begins."""

from radargui.cli import main

main()
