#!/bin/sh
# What surrounds the packages is well formed: desktop entry, AppStream, workflow, form for faults, citation. Run by name.
set -eu
cd "$(dirname "$0")/../.."
desktop-file-validate packaging/linux/radargui.desktop
appstreamcli validate --no-net packaging/linux/io.github.radargui.RadarGUI.metainfo.xml
check=${CHECK_JSONSCHEMA:-check-jsonschema}
if command -v "$check" >/dev/null; then
    "$check" --builtin-schema vendor.github-workflows .github/workflows/*.yml
    "$check" --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/*.yml
    "$check" --builtin-schema vendor.citation-file-format CITATION.cff
else
    echo "check-jsonschema is not here: workflow, form and citation were not checked"
fi
