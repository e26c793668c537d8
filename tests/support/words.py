"""What a finding says."""

from radargui.model.finding import Finding


def words(finding: Finding | None) -> str:
    """Return its text; empty where nothing was found."""
    return "" if finding is None else finding.text
