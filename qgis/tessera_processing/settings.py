"""The settings of the plugin: Settings > Options > Processing > Providers > Tessera."""
from processing.core.ProcessingConfig import ProcessingConfig, Setting

PROGRAM, SERVER = "TESSERA_PROGRAM", "TESSERA_SERVER"


def add(group, icon):
    ProcessingConfig.settingIcons[group] = icon
    ProcessingConfig.addSetting(Setting(group, PROGRAM, "The program tessera; empty: the one of the PATH", "", valuetype=Setting.FILE))
    ProcessingConfig.addSetting(Setting(group, SERVER, "The address of a daemon, for the algorithms that ask one", ""))
    ProcessingConfig.readSettings()


def remove():
    for name in (PROGRAM, SERVER):
        ProcessingConfig.removeSetting(name)


def program():
    return ProcessingConfig.getSetting(PROGRAM) or ""


def server():
    return ProcessingConfig.getSetting(SERVER) or ""
