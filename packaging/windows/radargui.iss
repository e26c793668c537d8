; Windows installer of the frozen folder: iscc /DVersion=0.1.0 packaging\windows\radargui.iss
#ifndef Version
  #define Version "0.0.0"
#endif

[Setup]
AppId={{6B0C5B0E-2F0B-4B57-9D43-5F6C4B1A7E10}
AppName=RadarGUI
AppVersion={#Version}
AppPublisher=RadarGUI contributors
DefaultDirName={autopf}\RadarGUI
DefaultGroupName=RadarGUI
LicenseFile=..\..\LICENSE
OutputDir=..\..\dist
OutputBaseFilename=radargui-{#Version}-windows
SetupIconFile=radargui.ico
UninstallDisplayIcon={app}\radargui-window.exe
ArchitecturesAllowed=x64compatible
ArchitecturesInstallIn64BitMode=x64compatible
Compression=lzma2/max
SolidCompression=yes
ChangesAssociations=yes
ChangesEnvironment=yes
; without an administrator it goes into the user's own folder
PrivilegesRequired=lowest
PrivilegesRequiredOverridesAllowed=dialog

[Tasks]
Name: desktopicon; Description: "{cm:CreateDesktopIcon}"; Flags: unchecked
Name: path; Description: "Let the command radargui be found in a terminal"; Flags: unchecked

[Files]
Source: "..\..\dist\radargui\*"; DestDir: "{app}"; Flags: recursesubdirs ignoreversion
Source: "..\..\LICENSE"; DestDir: "{app}"; DestName: "LICENSE.txt"

[Icons]
Name: "{group}\RadarGUI"; Filename: "{app}\radargui-window.exe"
Name: "{group}\Help"; Filename: "{app}\_internal\resources\help\index.html"
Name: "{group}\Command line"; Filename: "{cmd}"; Parameters: "/k ""{app}\radargui.exe"" --help"; WorkingDir: "{userdocs}"
Name: "{autodesktop}\RadarGUI"; Filename: "{app}\radargui-window.exe"; Tasks: desktopicon

; setups end in .toml, runs in .h5: others own these too, so RadarGUI is one of the programs of "Open with";
; a session is a folder named by its day, which gets an entry of its own
[Registry]
Root: HKA; Subkey: "Software\Classes\RadarGUI.Setup"; ValueType: string; ValueData: "RadarGUI setup"; Flags: uninsdeletekey
Root: HKA; Subkey: "Software\Classes\RadarGUI.Setup\DefaultIcon"; ValueType: string; ValueData: "{app}\radargui-window.exe,0"
Root: HKA; Subkey: "Software\Classes\RadarGUI.Setup\shell\open\command"; ValueType: string; ValueData: """{app}\radargui-window.exe"" --open ""%1"""
Root: HKA; Subkey: "Software\Classes\RadarGUI.Run"; ValueType: string; ValueData: "RadarGUI run"; Flags: uninsdeletekey
Root: HKA; Subkey: "Software\Classes\RadarGUI.Run\DefaultIcon"; ValueType: string; ValueData: "{app}\radargui-window.exe,0"
Root: HKA; Subkey: "Software\Classes\RadarGUI.Run\shell\open\command"; ValueType: string; ValueData: """{app}\radargui-window.exe"" --open ""%1"""
Root: HKA; Subkey: "Software\Classes\.toml\OpenWithProgids"; ValueType: string; ValueName: "RadarGUI.Setup"; ValueData: ""; Flags: uninsdeletevalue
Root: HKA; Subkey: "Software\Classes\.h5\OpenWithProgids"; ValueType: string; ValueName: "RadarGUI.Run"; ValueData: ""; Flags: uninsdeletevalue
Root: HKA; Subkey: "Software\Classes\Directory\shell\RadarGUI"; ValueType: string; ValueData: "Open session in RadarGUI"; Flags: uninsdeletekey
Root: HKA; Subkey: "Software\Classes\Directory\shell\RadarGUI"; ValueType: string; ValueName: "AppliesTo"; ValueData: "System.FileName:~<""20"""
Root: HKA; Subkey: "Software\Classes\Directory\shell\RadarGUI\command"; ValueType: string; ValueData: """{app}\radargui-window.exe"" --open ""%1"""
Root: HKA; Subkey: "Environment"; ValueType: expandsz; ValueName: "Path"; ValueData: "{olddata};{app}"; Tasks: path; Check: not IsAdminInstallMode

[Run]
Filename: "{app}\radargui-window.exe"; Description: "{cm:LaunchProgram,RadarGUI}"; Flags: nowait postinstall skipifsilent
