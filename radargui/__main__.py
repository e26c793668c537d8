"""`python -m radargui` is the command radargui."""

from radargui.cli import main

main()
