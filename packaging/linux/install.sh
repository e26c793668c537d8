#!/bin/sh
# Installs the frozen folder beside this script for one user: program, menu entry, icon, type of a run. --remove takes it away.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
data=${XDG_DATA_HOME:-$HOME/.local/share}
bin=$HOME/.local/bin
if [ "${1:-}" = --remove ]; then
    rm -rf "$data/radargui" "$bin/radargui" "$data/applications/radargui.desktop" "$data/mime/packages/radargui-mime.xml" \
        "$data/icons/hicolor/scalable/apps/radargui.svg" "$data/metainfo/io.github.radargui.RadarGUI.metainfo.xml"
    exit
fi
mkdir -p "$data/radargui" "$bin" "$data/applications" "$data/icons/hicolor/scalable/apps" "$data/mime/packages" "$data/metainfo"
cp -a "$here/radargui/." "$data/radargui/"
ln -sf "$data/radargui/radargui" "$bin/radargui"
cp "$here/radargui.desktop" "$data/applications/"
cp "$here/radargui/_internal/resources/window/radargui.svg" "$data/icons/hicolor/scalable/apps/"
cp "$here/radargui-mime.xml" "$data/mime/packages/"
cp "$here/io.github.radargui.RadarGUI.metainfo.xml" "$data/metainfo/"
update-desktop-database "$data/applications" 2>/dev/null || true
update-mime-database "$data/mime" 2>/dev/null || true
echo "Installed. Start RadarGUI from the menu, or $bin/radargui"
