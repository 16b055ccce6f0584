// Jobs that make a file below a result's exports. All work as do_work().
#pragma once

#include "src/service/processes/work.h"

namespace tessera {

Reply<JobDone> do_export(const Workshop& shop, const JobWork& work);
Reply<JobDone> do_dem(const Workshop& shop, const JobWork& work);
Reply<JobDone> do_contours(const Workshop& shop, const JobWork& work);
Reply<JobDone> do_surface(const Workshop& shop, const JobWork& work);

}  // namespace tessera
