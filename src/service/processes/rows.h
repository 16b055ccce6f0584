// The rows of the table of processes; each has a file of its own.
#pragma once

#include "src/service/processes/process.h"

namespace tessera::service {

extern const Process alpha_process;
extern const Process contours_process;
extern const Process dem_process;
extern const Process density_process;
extern const Process export_process;
extern const Process hag_process;
extern const Process info_process;
extern const Process measure_process;
extern const Process region_process;
extern const Process surface_process;
extern const Process triangulate_process;
extern const Process update_process;
extern const Process verify_process;
extern const Process volume_process;
extern const Process voronoi_process;

}  // namespace tessera::service
