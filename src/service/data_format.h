// Which versions of the service understand a data folder.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

// Notes the format of `data`, where none is noted yet. Error corrupt for a folder of a newer version, and for a note
// that is none; io.
Status check_data_format(const std::filesystem::path& data);

// Tells this data folder from any other, on whatever machine it is asked; made by whoever asks first. Errors io,
// corrupt.
Result<std::string> data_identity(const std::filesystem::path& data);

}  // namespace tessera
