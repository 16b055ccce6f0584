"""QGIS without a window, with a profile of its own that has the plugin of the build."""
import atexit
import os
import pathlib
import shutil
import tempfile
import zipfile

HOME = pathlib.Path(tempfile.mkdtemp(prefix="tessera-qgis-"))
atexit.register(shutil.rmtree, HOME, ignore_errors=True)
PLUGINS = HOME / ".local/share/QGIS/QGIS3/profiles/default/python/plugins"
PLUGINS.mkdir(parents=True)
with zipfile.ZipFile(os.environ["QGIS_PLUGIN"]) as archive:
    archive.extractall(PLUGINS)
ENVIRONMENT = os.environ | {"HOME": str(HOME), "XDG_RUNTIME_DIR": str(HOME), "QT_QPA_PLATFORM": "offscreen",
                            "QGIS_CUSTOM_CONFIG_PATH": str(HOME / ".local/share/QGIS/QGIS3"), "PYTHONDONTWRITEBYTECODE": "1",
                            "PATH": f"{pathlib.Path(os.environ['TESSERA']).parent}:{os.environ['PATH']}"}
# Debian's script adds an option of the desktop, which this program does not know.
PROCESS = shutil.which("qgis_process.bin") or shutil.which("qgis_process")
