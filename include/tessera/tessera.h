// All headers of the public library.
#pragma once

#include "tessera/alpha.h"
#include "tessera/delaunay.h"
#include "tessera/density.h"
#include "tessera/failure.h"
#include "tessera/heights.h"
#include "tessera/lines.h"
#include "tessera/options.h"
#include "tessera/questions.h"
#include "tessera/raster.h"
#include "tessera/region.h"
#include "tessera/triangulation.h"
#include "tessera/update.h"
#include "tessera/version.h"
#include "tessera/voids.h"
#include "tessera/volumes.h"
#include "tessera/voronoi.h"
