// Which versions of the service understand a data folder.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

// Notes the format of `data`, where none is noted yet. Error corrupt for a folder of a newer version, and for a note
// that is none; io.
Status check_data_format(const std::filesystem::path& data);

}  // namespace tessera
