// Volumes as a table: text for people, CSV, JSON, GeoPackage.
#pragma once

#include <filesystem>
#include <string>

#include "src/base/result.h"
#include "src/result/volume/volumes.h"

namespace tessera {

// What A, B and the signs are, in words, then the rows.
std::string to_text(const Volumes& volumes);
// A line of names of columns, then a line a row. Numbers have so many digits that the same doubles are read back. There
// are no columns `polygon` and `name` without polygons; `mean` is empty where nothing is covered.
std::string to_csv(const Volumes& volumes);
// One line of JSON, without its end; with `output` the name of the file that was written, if one was.
std::string to_json(const Volumes& volumes, const std::filesystem::path& output = {});

// Error usage when the name of the file does not end in .csv, .json or .gpkg, when the file exists and `overwrite` is
// not set, and for a GeoPackage of volumes without polygons.
Status check_volumes_target(const std::filesystem::path& target, bool polygons, bool overwrite);
// Writes a table; a GeoPackage has the polygons, too. The file appears whole or not at all. Error io.
Status write_volumes(const Volumes& volumes, const std::filesystem::path& target);

}  // namespace tessera
