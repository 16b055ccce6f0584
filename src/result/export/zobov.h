// ZOBOV's files of a tessellation, which its programs jozov and VIDE's and REVOLVER's read.
//
// Source: M. Neyrinck, ZOBOV: a parameter-free void-finding algorithm, MNRAS 386 (2008); the layout is what voztie.c of
// ZOBOV writes, and what jozov.c reads:
//   PREFIX.vol   i32 n, then n volumes, f32 (REVOLVER's programs: f64), in units of the mean
//   PREFIX.adj   i32 n, n times i32: how many neighbours a point has; then, for each point, i32 k, and k times i32:
//   those
//                of its neighbours that have a higher number
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

#include "src/result/export/mesh_source.h"
#include "src/result/export/output.h"
#include "src/result/export/point_table.h"
#include "src/result/export/row_numbers.h"

namespace tessera::exports {

enum class ZobovNumbers : std::uint8_t { floats, doubles };

inline constexpr std::uint64_t zobov_most = std::numeric_limits<std::int32_t>::max();
inline constexpr std::uint64_t zobov_most_at_one_place = 1000;

// Writes both files. Points at one place share the volume of their vertex evenly, and each is a neighbour of all others
// and of all neighbours. REQUIRES: `most` is at most zobov_most; less only in tests. Errors: usage for a result that is
// not periodic along all axes, that lacks Voronoi volumes, that has more than `most` points or more than
// zobov_most_at_one_place at one place, and for a volume that is no normal number of 32 bits; those of PointTable.
Result<Exported> write_zobov_files(const MeshSource& source, const std::filesystem::path& path, ZobovNumbers numbers,
                                   std::uint64_t most = zobov_most);

// Writes the bytes of PREFIX.adj. `rows` has the number of each row of the table.
Status write_zobov_neighbours(const MeshSource& source, const PointTable& table, const RowNumbers& rows,
                              const OutputFile& file);

}  // namespace tessera::exports
