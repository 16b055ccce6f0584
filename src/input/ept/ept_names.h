// The names of the files of a cloud in EPT. They are the format's, not ours.
#pragma once

namespace tessera {

// The file that describes the cloud. In its folder are those of the hierarchy and of the tiles.
inline constexpr const char* ept_file_name = "ept.json";
inline constexpr const char* ept_hierarchy_folder = "ept-hierarchy";
inline constexpr const char* ept_tiles_folder = "ept-data";

}  // namespace tessera
