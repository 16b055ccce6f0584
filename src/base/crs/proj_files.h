// Restricts the files that PROJ may open.
#pragma once

#include "src/base/crs/gdal_library.h"

namespace tessera {

// From this call on, PROJ finds files by name only in its own folders: those of PROJ_DATA and the folder with which it
// was installed. By default PROJ also looks into the current folder and into a writable folder: ~/.local/share/proj, or
// for users without a home /tmp/proj, which anyone may make. PROJ also stops using the network, whatever PROJ_NETWORK
// says. It still opens names with a folder as they are: see wkt.h. To be called before the first context of PROJ is
// made.
void keep_to_own_files(const GdalLibrary& gdal);

}  // namespace tessera
