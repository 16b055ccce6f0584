// Which files PROJ may open.
#pragma once

#include "src/base/crs/gdal_library.h"

namespace tessera {

// From now on PROJ, in this process, finds files by their names in its own folders alone: those of PROJ_DATA, and the
// one it was installed with. Without that it also looks into the current folder, and into a writable one:
// ~/.local/share/proj, or /tmp/proj, which anybody may make, for users without a home. It asks nobody on the net,
// whatever PROJ_NETWORK says. Names with a folder it opens as they are: see wkt.h. Before its first context is made.
void keep_to_own_files(const GdalLibrary& gdal);

}  // namespace tessera
